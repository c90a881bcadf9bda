#include "controller/monitor/tallies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace granary::monitor {

namespace {

constexpr const char* kAdvice = "The file was cut or changed after granary-dem wrote it: run the burst again.";

Error wrong(const std::string& place, const std::string& member, const std::string& what) {
  return Error{fmt::format("{}: /{} {}. {}", place, member, what, kAdvice)};
}

/// An array of `size` numbers, none negative or missing.
Result<std::vector<double>> counts(const json::Value& line, const std::string& key, std::size_t size,
                                   const std::string& place) {
  std::vector<double> values = line.numbers(key);
  if (!line[key].is_array() || values.size() != size)
    return wrong(place, key, fmt::format("has {} numbers; the header promises {}", values.size(), size));
  for (const double value : values)
    if (!(value >= 0.0)) return wrong(place, key, "holds a number that is negative or missing; counts are >= 0");
  return values;
}

Result<std::vector<std::vector<double>>> count_rows(const json::Value& line, const std::string& key, std::size_t rows,
                                                    std::size_t columns, const std::string& place) {
  const json::Value& table = line[key];
  if (!table.is_array() || table.size() != rows)
    return wrong(place, key, fmt::format("has {} rows; the header promises {}", table.size(), rows));
  std::vector<std::vector<double>> values;
  for (std::size_t r = 0; r < rows; ++r) {
    const auto row = json::Value::object({{key, table.items()[r]}});
    GRANARY_TRY(std::vector<double> numbers, counts(row, key, columns, place));
    values.push_back(std::move(numbers));
  }
  return values;
}

/// Moments of speeds are null where nothing was counted.
SpeedMoments moments(const json::Value& value) {
  SpeedMoments read{value.number_or("count", 0.0), value.number_or("ln_mean", 0.0),
                    value.number_or("ln_variance", 0.0)};
  if (!(read.count > 0.0)) read = {};
  return read;
}

bool ascending(const std::vector<double>& edges) {
  return edges.size() >= 2 &&
         std::adjacent_find(edges.begin(), edges.end(), [](double a, double b) { return !(a < b); }) == edges.end();
}

}  // namespace

double TallyWindow::total_collisions() const {
  double total = 0.0;
  for (std::size_t p = 0; p < collisions.size(); ++p)
    for (std::size_t q = p; q < collisions.size(); ++q) total += collisions[p][q];
  return total;
}

double TallyWindow::total_impacts() const { return std::accumulate(impacts.begin(), impacts.end(), 0.0); }

std::vector<double> TallyWindow::particles_by_class() const {
  std::vector<double> total(impacts.size(), 0.0);
  for (const auto& compartment : particles)
    for (std::size_t p = 0; p < total.size(); ++p) total[p] += compartment[p];
  return total;
}

double TallyWindow::total_particles() const {
  const std::vector<double> by_class = particles_by_class();
  return std::accumulate(by_class.begin(), by_class.end(), 0.0);
}

Result<TallyHeader> read_tally_header(const json::Value& line, const std::string& place) {
  if (line.text_or("format", "") != "granary-tallies-1")
    return Error{fmt::format(
        "{}: /format is \"{}\"; it must be \"granary-tallies-1\". Is this the tallies.jsonl of granary-dem?", place,
        line.text_or("format", ""))};
  TallyHeader header;
  header.class_edge = line.numbers("class_edges_m");
  header.compartment_edge = line.numbers("compartment_edges_m");
  if (!ascending(header.class_edge)) return wrong(place, "class_edges_m", "must hold at least 2 ascending numbers");
  if (!ascending(header.compartment_edge))
    return wrong(place, "compartment_edges_m", "must hold at least 2 ascending numbers");
  if (line["bodies"].is_array())
    for (const json::Value& body : line["bodies"].items())
      if (body.is_string()) header.bodies.push_back(body.as_string());
  header.window = line.number_or("window_s", 0.0);
  if (!(header.window > 0.0)) return wrong(place, "window_s", "must be > 0");
  header.coarse_graining = line.number_or("coarse_graining", 1.0);
  if (!(header.coarse_graining > 0.0)) return wrong(place, "coarse_graining", "must be > 0");
  return header;
}

Result<TallyWindow> read_tally_window(const json::Value& line, const TallyHeader& header, const std::string& place) {
  const std::size_t n_classes = header.n_classes(), n_compartments = header.n_compartments();
  TallyWindow window;
  const double nan = std::nan("");
  window.time = line.number_or("time_s", nan);
  if (!std::isfinite(window.time)) return wrong(place, "time_s", "is missing");
  window.window = line.number_or("window_s", header.window);
  if (!(window.window > 0.0)) return wrong(place, "window_s", "must be > 0");
  GRANARY_TRY(window.particles, count_rows(line, "particles", n_compartments, n_classes, place));
  GRANARY_TRY(window.collisions, count_rows(line, "collisions", n_classes, n_classes, place));
  GRANARY_TRY(window.collisions_by_compartment, counts(line, "collisions_by_compartment", n_compartments, place));
  window.impacts.assign(n_classes, 0.0);
  for (const std::string& body : header.bodies) {
    GRANARY_TRY(const std::vector<double> of_body, counts(line["impacts"], body, n_classes, place + ": /impacts"));
    for (std::size_t p = 0; p < n_classes; ++p) window.impacts[p] += of_body[p];
  }
  window.collision_speed = moments(line["collision_speed"]);
  window.impact_speed = moments(line["impact_speed"]);
  window.speed_mean = line.numbers("speed_mean_m_s");
  window.speed_rms = line.numbers("speed_rms_m_s");
  if (window.speed_mean.size() != n_classes) return wrong(place, "speed_mean_m_s", "must hold a number a class");
  if (window.speed_rms.size() != n_classes) return wrong(place, "speed_rms_m_s", "must hold a number a class");
  return window;
}

std::optional<Divergence> read_divergence(const json::Value& line) {
  const json::Value* record = line.find("diverged");
  if (record == nullptr) return std::nullopt;
  return Divergence{record->text_or("cause", "unknown"), record->text_or("message", ""),
                    record->number_or("time_s", 0.0), *record};
}

Result<Tallies> read_tallies(const std::vector<json::Value>& lines, const std::string& file) {
  if (lines.empty())
    return Error{
        fmt::format("{}: is empty: granary-dem stopped before it measured anything. See dem.out beside it.", file)};
  Tallies tallies;
  GRANARY_TRY(tallies.header, read_tally_header(lines.front(), file + ", line 1"));
  for (std::size_t n = 1; n < lines.size(); ++n) {
    if ((tallies.diverged = read_divergence(lines[n]))) break;
    GRANARY_TRY(TallyWindow window,
                read_tally_window(lines[n], tallies.header, fmt::format("{}, line {}", file, n + 1)));
    tallies.windows.push_back(std::move(window));
  }
  return tallies;
}

}  // namespace granary::monitor
