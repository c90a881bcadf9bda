#include "controller/monitor/watched.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/json/io.hpp"

namespace granary::monitor {

namespace {

std::vector<Property> dem_properties(std::size_t n_classes) {
  std::vector<Property> properties{{"collisions_per_particle_s", "all", true}, {"impacts_per_particle_s", "all", true}};
  for (std::size_t p = 0; p < n_classes; ++p)
    properties.push_back({"speed_mean_m_s", fmt::format("class {}", p + 1), false});
  return properties;
}

/// Per particle: a bed that lost some of its particles through the outlet has not changed the way it is stirred.
Sample count_sample(double count, const TallyWindow& window, double particles, int average) {
  const double exposure = std::max(particles, 1.0) * window.window;
  return {count / exposure, std::sqrt(std::max(count, 1.0)) / exposure, kLeastCounts / (average * exposure)};
}

Sample speed_sample(const TallyWindow& window, std::size_t p, double particles) {
  const double mean = window.speed_mean[p], rms = window.speed_rms[p];
  if (particles < kLeastParticles || !std::isfinite(mean) || !std::isfinite(rms)) return {std::nan(""), 0.0, 0.0};
  return {mean, std::sqrt(std::max(rms * rms - mean * mean, 0.0) / particles), 0.0};
}

Row dem_row(const TallyWindow& window, int average) {
  const std::vector<double> particles = window.particles_by_class();
  Row row{window.time - window.window, window.time, {}};
  const double all = std::accumulate(particles.begin(), particles.end(), 0.0);
  row.samples.push_back(count_sample(window.total_collisions(), window, all, average));
  row.samples.push_back(count_sample(window.total_impacts(), window, all, average));
  for (std::size_t p = 0; p < particles.size(); ++p) row.samples.push_back(speed_sample(window, p, particles[p]));
  return row;
}

std::vector<Property> pbm_properties(std::size_t n_compartments) {
  std::vector<Property> properties;
  for (std::size_t x = 0; x < n_compartments; ++x) {
    properties.push_back({"d50_m", fmt::format("compartment {}", x + 1), true});
    properties.push_back({"number", fmt::format("compartment {}", x + 1), true});
  }
  return properties;
}

Row pbm_row(double time, const std::vector<double>& d50, const std::vector<double>& number,
            const std::vector<double>& solid) {
  const double fullest = *std::max_element(solid.begin(), solid.end());
  const double most = *std::max_element(number.begin(), number.end());
  Row row{time, time, {}};
  for (std::size_t x = 0; x < d50.size(); ++x) {
    const bool occupied = solid[x] >= kLeastShare * fullest;
    row.samples.push_back({occupied ? d50[x] : std::nan(""), 0.0, 0.0});
    row.samples.push_back({number[x], 0.0, occupied ? 0.0 : kLeastShare * most});
  }
  return row;
}

}  // namespace

std::string_view watched_file(Program program) { return program == Program::dem ? "tallies.jsonl" : "progress.jsonl"; }

Options default_options(Program program) {
  Options options;
  if (program == Program::pbm) {
    options.grace = 0.0;
    options.average = 1;
  }
  return options;
}

Watch::Watch(Program program, Options options, std::string file)
    : program_(program), options_(options), file_(std::move(file)) {}

Result<Verdict> Watch::take(const json::Value& line) {
  ++line_;
  const std::string place = fmt::format("{}, line {}", file_, line_);
  if (const auto divergence = read_divergence(line))
    return diverged(fmt::format("{}: {}", divergence->cause, divergence->message), divergence->time,
                    divergence->record);
  return program_ == Program::dem ? take_tally(line, place) : take_progress(line, place);
}

Verdict Watch::ended() const {
  if (criteria_) return criteria_->ended();
  Verdict said;
  said.outcome = Outcome::ended;
  said.message = file_ + " held nothing when the program ended";
  return said;
}

Verdict Watch::diverged(std::string cause_message, double time, json::Value record) const {
  Verdict said;
  said.outcome = Outcome::diverged;
  said.watched = record.text_or("cause", "");
  said.value = record.number_or("value", 0.0);
  said.threshold = record.number_or("bound", 0.0);
  said.time = time;
  said.burst_start = criteria_ ? criteria_->burst_start() : 0.0;
  said.lines = line_ > 0 ? line_ - 1 : 0;
  said.message = std::move(cause_message);
  said.details = std::move(record);
  return said;
}

Result<Verdict> Watch::take_tally(const json::Value& line, const std::string& place) {
  if (!header_) {
    GRANARY_TRY(header_, read_tally_header(line, place));
    criteria_.emplace(options_, dem_properties(header_->n_classes()));
    return Verdict{};
  }
  GRANARY_TRY(const TallyWindow window, read_tally_window(line, *header_, place));
  return criteria_->add(dem_row(window, options_.average));
}

Result<Verdict> Watch::take_progress(const json::Value& line, const std::string& place) {
  constexpr const char* kAdvice = "The file was cut or changed after granary-pbm wrote it: run the burst again.";
  if (!criteria_) {
    if (line.text_or("format", "") != "granary-progress-1")
      return Error{fmt::format(
          "{}: /format is \"{}\"; it must be \"granary-progress-1\". Is this the progress.jsonl of granary-pbm?", place,
          line.text_or("format", ""))};
    const std::int64_t count = line.integer_or("compartments", 0);
    if (count < 1) return Error{fmt::format("{}: /compartments is {}; it must be >= 1. {}", place, count, kAdvice)};
    n_compartments_ = static_cast<std::size_t>(count);
    criteria_.emplace(options_, pbm_properties(n_compartments_));
    return Verdict{};
  }
  const double time = line.number_or("time_s", std::nan(""));
  if (!std::isfinite(time)) return Error{fmt::format("{}: /time_s is missing. {}", place, kAdvice)};
  const std::vector<double> d50 = line.numbers("d50_m"), number = line.numbers("number"),
                            solid = line.numbers("solid_m3");
  for (const auto& [key, values] : {std::pair{"d50_m", &d50}, {"number", &number}, {"solid_m3", &solid}}) {
    if (values->size() != n_compartments_)
      return Error{fmt::format("{}: /{} has {} numbers; the header promises {}. {}", place, key, values->size(),
                               n_compartments_, kAdvice)};
    for (std::size_t x = 0; x < values->size(); ++x)
      if (!std::isfinite((*values)[x]))
        return diverged(fmt::format("{} in compartment {} is not a number at {:.6g} s", key, x + 1, time), time,
                        json::Value::object(
                            {{"cause", "not_a_number"}, {"watched", key}, {"compartment", x + 1}, {"time_s", time}}));
  }
  const bool empty = std::accumulate(number.begin(), number.end(), 0.0) <= 0.0;
  if (empty) return Verdict{};  // a process that fills from nothing: the first particles are its start
  return criteria_->add(pbm_row(time, d50, number, solid));
}

Result<Verdict> judge_file(Program program, const Options& options, const std::filesystem::path& file) {
  GRANARY_TRY(const std::vector<json::Value> lines, json::read_lines(file));
  Watch watch(program, options, file.string());
  for (const json::Value& line : lines) {
    GRANARY_TRY(Verdict said, watch.take(line));
    if (said.outcome != Outcome::none) return said;
  }
  return watch.ended();
}

}  // namespace granary::monitor
