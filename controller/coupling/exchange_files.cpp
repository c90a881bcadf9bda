#include "controller/coupling/exchange_files.hpp"

#include <fmt/format.h>

#include <algorithm>

#include <cmath>

#include "common/json/io.hpp"
#include "common/results/hdf5_file.hpp"

namespace granary::coupling {

namespace fs = std::filesystem;

namespace {

constexpr double kSameTime = 1e-9;

Result<std::size_t> row_at(const std::vector<double>& times, std::optional<double> time, const fs::path& file) {
  if (times.empty())
    return Error{fmt::format("{}: holds no state: granary-pbm ended before its first output. See pbm.out beside it.",
                             file.string())};
  if (!time) return times.size() - 1;
  std::size_t nearest = 0;
  for (std::size_t r = 0; r < times.size(); ++r) {
    if (std::abs(times[r] - *time) <= kSameTime * std::max(1.0, std::abs(*time))) return r;
    if (std::abs(times[r] - *time) < std::abs(times[nearest] - *time)) nearest = r;
  }
  return Error{
      fmt::format("{}: has no state at {:.9g} s; it goes from {:.6g} s to {:.6g} s, and the nearest is at {:.9g} s. Is "
                  "it the file of another "
                  "burst?",
                  file.string(), *time, times.front(), times.back(), times[nearest])};
}

std::vector<Matrix> unflatten(const std::vector<double>& row, std::size_t n_x, std::size_t n_1, std::size_t n_2) {
  std::vector<Matrix> tables(n_x, Matrix(n_1, std::vector<double>(n_2)));
  auto value = row.begin();
  for (Matrix& table : tables)
    for (std::vector<double>& line : table)
      for (double& cell : line) cell = *value++;
  return tables;
}

/// The solver keeps every class non-negative but for round-off: what is below 0 by less than 1e-12 of the largest is
/// none.
void forgive_round_off(std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, value);
  for (double& value : values)
    if (value < 0.0 && value >= -1e-12 * largest) value = 0.0;
}

}  // namespace

Result<monitor::Tallies> read_tallies(const fs::path& file) {
  GRANARY_TRY(const std::vector<json::Value> lines, json::read_lines(file));
  return monitor::read_tallies(lines, file.string());
}

Result<HoldUp> read_hold_up(const fs::path& file, std::optional<double> time) {
  std::error_code fault;
  if (!fs::exists(file, fault))
    return Error{fmt::format(
        "{}: there is no such file: granary-pbm did not get as far as its first output. See pbm.out beside it.",
        file.string())};
  GRANARY_TRY(const Hdf5File h5, Hdf5File::open(file));
  GRANARY_TRY(const std::string format, h5.text_attribute("/", "format"));
  if (format != "granary-pbm-out-1")
    return Error{fmt::format(
        "{}: its format is \"{}\"; it must be \"granary-pbm-out-1\". Was it written by another version of Granary?",
        file.string(), format)};
  GRANARY_TRY(DataArray solid_1, h5.read("/grid/solid_1"));
  GRANARY_TRY(DataArray solid_2, h5.read("/grid/solid_2"));
  GRANARY_TRY(const DataArray times, h5.read("/state/time"));
  GRANARY_TRY(const std::size_t row, row_at(times.values, time, file));

  HoldUp hold_up;
  hold_up.time = times.values[row];
  hold_up.solid_1 = std::move(solid_1.values);
  hold_up.solid_2 = std::move(solid_2.values);
  const std::size_t n_1 = hold_up.solid_1.size(), n_2 = hold_up.solid_2.size();
  std::size_t n_x = 0;
  for (const auto& [name, target] : {std::pair{"/state/number", &hold_up.number},
                                     {"/state/liquid", &hold_up.liquid},
                                     {"/state/gas", &hold_up.gas}}) {
    GRANARY_TRY(std::vector<double> values, h5.read_row(name, row));
    forgive_round_off(values);
    const std::size_t here = n_1 * n_2 > 0 ? values.size() / (n_1 * n_2) : 0;
    if (n_x == 0) n_x = here;
    if (here == 0 || here != n_x || values.size() != n_x * n_1 * n_2)
      return Error{fmt::format(
          "{}: {} has {} values a row, which does not fit a grid of {} x {}. The file is damaged: run the burst again.",
          file.string(), name, values.size(), n_1, n_2)};
    *target = unflatten(values, n_x, n_1, n_2);
  }
  return hold_up;
}

Result<MeasuredRates> measure_burst(const fs::path& burst_folder, const std::vector<double>& bed_volume,
                                    const RateSettings& settings) {
  const fs::path file = burst_folder / "tallies.jsonl";
  GRANARY_TRY(const monitor::Tallies tallies, read_tallies(file));
  auto measured = measure_rates(tallies, bed_volume, settings);
  if (!measured) return Error{fmt::format("{}: {}", file.string(), measured.error().message), measured.error().exit};
  return measured;
}

Result<double> fastest_contacts(const fs::path& file) {
  constexpr double kShare = 1e-3;
  GRANARY_TRY(const std::vector<json::Value> lines, json::read_lines(file));
  if (lines.empty()) return Error{fmt::format("{}: it is empty.", file.string())};
  const std::vector<double> edges = lines.front().numbers("speed_edges_m_s");
  if (edges.size() < 2) return Error{fmt::format("{}: line 1: speed_edges_m_s is missing.", file.string())};
  std::vector<double> counts(edges.size() - 1, 0.0);
  for (const json::Value& line : lines) {
    for (const char* kind : {"collision_speed", "impact_speed"}) {
      const std::vector<double> histogram = line[kind].numbers("histogram");
      for (std::size_t h = 0; h < std::min(histogram.size(), counts.size()); ++h) counts[h] += histogram[h];
    }
  }
  double total = 0.0, above = 0.0;
  for (const double count : counts) total += count;
  if (total * kShare < 1.0) return 0.0;
  std::size_t bin = counts.size();
  while (bin > 1 && above + counts[bin - 1] <= kShare * total) above += counts[--bin];
  return edges[bin];
}

}  // namespace granary::coupling
