#include "controller/run/collect.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/json/io.hpp"
#include "common/math/size_distribution.hpp"
#include "common/results/hdf5_file.hpp"
#include "controller/coupling/exchange_files.hpp"
#include "controller/run/choices.hpp"
#include "controller/run/collect_estimation.hpp"
#include "controller/run/provenance.hpp"

namespace granary::run {
namespace fs = std::filesystem;
using coupling::BurstRecord;
using coupling::Kind;

namespace {

fs::path folder_of(const fs::path& dir, const coupling::BurstId& burst) { return dir / "bursts" / burst.folder(); }

std::int64_t number_of(const BurstRecord& record) { return record.burst.round; }

// ---- PBM series

void append_numbers(Rows& rows, const json::Value& line, std::string_view key) { rows.push_back(line.numbers(key)); }

/// The progress of one burst, up to where the DEM took over: what the program did beyond that was discarded.
Status append_progress(PbmSeries& series, const BurstRecord& record, const fs::path& folder) {
  GRANARY_TRY(const auto lines, json::LineReader(folder / "progress.jsonl").next());
  for (const json::Value& line : lines) {
    const double time = line.number_or("time_s", kNone);
    if (!(time <= record.end_time * (1.0 + 1e-12) + 1e-12)) continue;
    series.time.push_back(time);
    series.burst.push_back(number_of(record));
    append_numbers(series.number, line, "number");
    append_numbers(series.d10, line, "d10_m");
    append_numbers(series.d50, line, "d50_m");
    append_numbers(series.d90, line, "d90_m");
    append_numbers(series.porosity, line, "porosity");
    append_numbers(series.solid, line, "solid_m3");
    append_numbers(series.liquid, line, "liquid_m3");
    append_numbers(series.gas, line, "gas_m3");
    const json::Value& outlet = line["outlet"];
    series.outlet_d10.push_back(outlet.number_or("d10_m", kNone));
    series.outlet_d50.push_back(outlet.number_or("d50_m", kNone));
    series.outlet_d90.push_back(outlet.number_or("d90_m", kNone));
    series.outlet_solid.push_back(outlet.number_or("solid_kg_s", kNone));
    series.outlet_number.push_back(outlet.number_or("number_1_s", kNone));
    series.outlet_liquid_fraction.push_back(outlet.number_or("liquid_fraction", kNone));
    const json::Value& drift = line["drift"];
    series.drift_solid_1.push_back(drift.number_or("solid_1", kNone));
    series.drift_solid_2.push_back(drift.number_or("solid_2", kNone));
    series.drift_liquid.push_back(drift.number_or("liquid", kNone));
    series.drift_gas.push_back(drift.number_or("gas", kNone));
    series.oversize.push_back(line.number_or("oversize_m3", kNone));
  }
  return {};
}

// ---- size distributions

/// One class per grid ratio in diameter: finer classes would show the gaps between the pivots.
std::vector<double> diameter_edges(const pbm::Grid& grid) {
  const double ratio = std::cbrt(std::min(grid.ratio[0], grid.ratio[1]));
  const double smallest = sphere_diameter(std::min(grid.smallest[0], grid.smallest[1]));
  double largest_volume = 0.0;
  for (int k = 0; k < 2; ++k) largest_volume += grid.smallest[k] * std::pow(grid.ratio[k], grid.bins[k] - 1);
  std::vector<double> edges{smallest / std::sqrt(ratio)};
  while (edges.back() < 1.5 * sphere_diameter(largest_volume)) edges.push_back(edges.back() * ratio);
  return edges;
}

struct ClassVolume {
  double diameter = 0.0;  ///< of one particle [m]
  double volume = 0.0;    ///< of all of them [m^3]
  double each = 0.0;      ///< of one particle [m^3]
};

ClassVolume class_volume(const coupling::HoldUp& state, std::size_t x, std::size_t i, std::size_t j) {
  const double number = state.number[x][i][j];
  if (!(number > 0.0)) return {};
  const double volume = number * (state.solid_1[i] + state.solid_2[j]) + state.liquid[x][i][j] + state.gas[x][i][j];
  return {sphere_diameter(volume / number), volume, volume / number};
}

void add_to(std::vector<double>& shares, const std::vector<double>& edges, double diameter, double volume) {
  const auto above = std::upper_bound(edges.begin(), edges.end(), diameter);
  const auto at =
      std::clamp<std::ptrdiff_t>(above - edges.begin() - 1, 0, static_cast<std::ptrdiff_t>(shares.size()) - 1);
  shares[static_cast<std::size_t>(at)] += volume;
}

void to_shares(std::vector<double>& volumes) {
  const double total = std::accumulate(volumes.begin(), volumes.end(), 0.0);
  if (total > 0.0)
    for (double& volume : volumes) volume /= total;
}

/// @param outlet  particles a second of each class that flow out, row-major (N1, N2); empty: nothing does
void append_distribution(SizeDistributions& sizes, const coupling::HoldUp& state, const std::vector<double>& outlet,
                         const std::string& when) {
  const std::size_t n_classes = sizes.edge.size() - 1, n2 = state.solid_2.size();
  Rows table;
  std::vector<double> out(n_classes, 0.0);
  for (std::size_t x = 0; x < state.n_compartments(); ++x) {
    std::vector<double> shares(n_classes, 0.0);
    for (std::size_t i = 0; i < state.solid_1.size(); ++i)
      for (std::size_t j = 0; j < n2; ++j) {
        const ClassVolume of = class_volume(state, x, i, j);
        if (of.volume <= 0.0) continue;
        add_to(shares, sizes.edge, of.diameter, of.volume);
        if (x + 1 == state.n_compartments() && !outlet.empty())
          add_to(out, sizes.edge, of.diameter, of.each * outlet[i * n2 + j]);
      }
    to_shares(shares);
    table.push_back(std::move(shares));
  }
  to_shares(out);
  sizes.when.push_back(when);
  sizes.time.push_back(state.time);
  sizes.compartments.push_back(std::move(table));
  sizes.outlet.push_back(std::move(out));
}

Result<std::vector<double>> outlet_rate(const fs::path& out_h5, double time) {
  GRANARY_TRY(const Hdf5File file, Hdf5File::open(out_h5));
  if (!file.has("/outlet/number_rate")) return std::vector<double>{};
  GRANARY_TRY(const DataArray times, file.read("/state/time"));
  for (std::size_t row = 0; row < times.values.size(); ++row)
    if (std::abs(times.values[row] - time) <= 1e-9 * (1.0 + std::abs(time)))
      return file.read_row("/outlet/number_rate", row);
  return std::vector<double>{};
}

// ---- DEM series and rates

Status append_tallies(DemSeries& series, const BurstRecord& record, const fs::path& folder) {
  GRANARY_TRY(const auto lines, json::LineReader(folder / "tallies.jsonl").next());
  if (lines.empty()) return {};
  if (series.bodies.empty())
    for (const json::Value& body : lines.front()["bodies"].items()) series.bodies.push_back(body.as_string());
  GRANARY_TRY(const auto tallies, coupling::read_tallies(folder / "tallies.jsonl"));
  for (std::size_t w = 0; w < tallies.windows.size(); ++w) {
    const monitor::TallyWindow& window = tallies.windows[w];
    const json::Value& line = lines[w + 1];
    series.time.push_back(window.time);
    series.burst.push_back(number_of(record));
    series.particles.push_back(window.total_particles());
    series.collisions.push_back(window.total_collisions() / window.window);
    std::vector<double> impacts, torque, power;
    for (const std::string& body : series.bodies) {
      const auto by_class = line["impacts"].numbers(body);
      impacts.push_back(std::accumulate(by_class.begin(), by_class.end(), 0.0) / window.window);
    }
    for (const std::string& body : series.bodies) {
      const json::Value& load = line["loads"][body];
      torque.push_back(-load.number_or("axial_torque_N_m", kNone));
      power.push_back(load.number_or("power_W", kNone));
    }
    series.impacts.push_back(std::move(impacts));
    series.torque.push_back(std::move(torque));
    series.power.push_back(std::move(power));
    series.speed.push_back(window.speed_mean);
    series.kinetic_energy.push_back(line.number_or("kinetic_energy_J", kNone));
    series.largest_overlap.push_back(line.number_or("largest_overlap", kNone));
  }
  return {};
}

/// Bursts may differ in their number of size classes: all rows as wide as the widest.
void pad(Rows& rows) {
  std::size_t width = 0;
  for (const auto& row : rows) width = std::max(width, row.size());
  for (auto& row : rows) row.resize(width, kNone);
}

/// Counts per speed bin over the windows after the grace time, at real sizes.
Result<SpeedHistogram> speeds(const fs::path& folder, const std::string& which, const pbm::SpeedDistribution& fitted,
                              double scale, double grace) {
  GRANARY_TRY(const auto lines, json::LineReader(folder / "tallies.jsonl").next());
  SpeedHistogram histogram;
  histogram.ln_mean = fitted.ln_mean;
  histogram.ln_sigma = fitted.ln_sigma;
  for (const double edge : lines.front().numbers("speed_edges_m_s")) histogram.edge.push_back(edge * scale);
  histogram.count.assign(std::max<std::size_t>(histogram.edge.size(), 1) - 1, 0.0);
  double begin = kNone;
  for (const json::Value& line : lines) {
    const double start = line.number_or("time_s", kNone) - line.number_or("window_s", 0.0);
    if (std::isnan(start)) continue;
    if (std::isnan(begin)) begin = start;
    if (start < begin + grace - 1e-12) continue;
    const auto counts = line[which].numbers("histogram");
    for (std::size_t h = 0; h < std::min(counts.size(), histogram.count.size()); ++h) histogram.count[h] += counts[h];
  }
  return histogram;
}

Result<DemRates> rates_of(const BurstRecord& record, const coupling::MeasuredRates& measured, const fs::path& folder,
                          double grace) {
  DemRates rates;
  rates.burst = number_of(record);
  rates.measured = measured.summary.end_time - measured.summary.start_time;
  rates.diameter = measured.rates.diameter;
  rates.collisions = measured.collisions;
  rates.collision_rate = measured.rates.collision_rate;
  rates.collision_rate_error = measured.standard_error;
  rates.impact_rate = measured.rates.impact_rate;
  for (std::size_t p = 0; p < rates.impact_rate.size(); ++p)
    rates.impact_rate_error.push_back(measured.impacts[p] > 0.0 ? rates.impact_rate[p] / std::sqrt(measured.impacts[p])
                                                                : kNone);
  const coupling::Carry& carry = measured.carry;
  GRANARY_TRY(rates.collision_speed,
              speeds(folder, "collision_speed", measured.rates.collision_speed, carry.collision_speed, grace));
  GRANARY_TRY(rates.impact_speed,
              speeds(folder, "impact_speed", measured.rates.impact_speed, carry.impact_speed, grace));
  return rates;
}

// ---- bursts

/// d50 by volume and number of all compartments together.
void state_into(BurstSummary& burst, const coupling::HoldUp& state) {
  std::vector<double> diameter, volume;
  burst.particles = 0.0;
  for (std::size_t x = 0; x < state.n_compartments(); ++x)
    for (std::size_t i = 0; i < state.solid_1.size(); ++i)
      for (std::size_t j = 0; j < state.solid_2.size(); ++j) {
        const ClassVolume of = class_volume(state, x, i, j);
        burst.particles += state.number[x][i][j];
        diameter.push_back(of.diameter);
        volume.push_back(of.volume);
      }
  burst.d50 = quantile(diameter, volume, 0.5, log_width_of_pivots(state.solid_1, state.solid_2));
}

/// The last burst of a campaign that failed while its result was carried over.
bool could_not_be_handed_over(const coupling::State& state, const BurstRecord& over) {
  return state.ended == coupling::End::How::failed && over == state.bursts.back() && over.burst == state.burst;
}

BurstSummary summary_of(const BurstRecord& record, const std::vector<pilot::TaskEnd>& ends) {
  BurstSummary burst;
  burst.number = number_of(record);
  burst.kind = record.burst.kind == Kind::dem ? "dem" : "pbm";
  burst.reason = record.message.empty() ? record.reason : record.reason + ": " + record.message;
  burst.process_start = burst.process_end = burst.dem_start = burst.dem_end = kNone;
  (record.burst.kind == Kind::dem ? burst.dem_start : burst.process_start) = record.start_time;
  (record.burst.kind == Kind::dem ? burst.dem_end : burst.process_end) = record.end_time;
  burst.coarse_graining = burst.dem_particles = burst.d50 = burst.particles = kNone;
  const auto name = program_name(record.burst, record.attempt);
  for (const pilot::TaskEnd& end : ends) {
    if (end.name != name) continue;
    burst.wall = end.end - end.start;
    burst.cores = static_cast<std::int64_t>(end.cores.size());
    burst.exit_code = end.exit_code;
  }
  return burst;
}

}  // namespace

Result<CampaignResults> collect(const campaign::Campaign& campaign, const FileHandover& handover, const fs::path& dir,
                                const RunRecord& record) {
  CampaignResults results;
  GRANARY_TRY(results.provenance, provenance_of(campaign, dir, record.state));
  results.provenance.started = record.started;
  results.provenance.finished = record.finished;
  results.ended = record.state.ended ? std::string(coupling::name(*record.state.ended)) : "unfinished";
  results.message = record.state.why_ended.message;

  results.sizes.edge = diameter_edges(campaign.pbm_case.grid);
  if (auto start = coupling::starting_hold_up(campaign.pbm_case))
    append_distribution(results.sizes, *start, {}, "start");

  double process_clock = campaign.pbm_case.start_time, dem_clock = 0.0;
  for (const BurstRecord& over : record.state.bursts) {
    const fs::path folder = folder_of(dir, over.burst);
    BurstSummary burst = summary_of(over, record.ends);
    if (could_not_be_handed_over(record.state, over)) {
      // Its files may be short of what the others have: it is named, and that is all.
    } else if (over.burst.kind == Kind::dem) {
      GRANARY_CHECK(append_tallies(results.dem, over, folder));
      GRANARY_TRY(const auto measured, handover.rates_of(over.burst));
      GRANARY_TRY(DemRates rates, rates_of(over, measured, folder, campaign.coupling.grace));
      results.rates.push_back(std::move(rates));
      burst.coarse_graining = measured.coarse_graining;
      burst.dem_particles = measured.summary.particles;
      burst.process_start = burst.process_end = process_clock;
      dem_clock = over.end_time;
    } else {
      GRANARY_CHECK(append_progress(results.pbm, over, folder));
      GRANARY_TRY(const auto state, coupling::read_hold_up(folder / "out.h5", over.end_time));
      GRANARY_TRY(const auto outlet, outlet_rate(folder / "out.h5", over.end_time));
      append_distribution(results.sizes, state, outlet, fmt::format("after burst {}", over.burst.round));
      state_into(burst, state);
      burst.dem_start = burst.dem_end = dem_clock;
      process_clock = over.end_time;
    }
    results.bursts.push_back(std::move(burst));
  }
  if (results.sizes.when.size() > 1) results.sizes.when.back() = "end";
  pad(results.dem.speed);

  for (const pilot::Interval& interval : record.timeline)
    results.timeline.push_back({interval.name,
                                kind_of_task(interval.name, interval.fill),
                                interval.attempt,
                                {interval.cores.begin(), interval.cores.end()},
                                interval.start,
                                interval.end});
  results.core_use = core_use(results.timeline, record.cores, record.wall);
  if (campaign.estimation) {
    GRANARY_TRY(results.estimation, estimation_of(campaign, dir, record.estimation, results.core_use));
  }
  GRANARY_TRY(results.choices, choices_of(campaign, dir, record.state, results));
  return results;
}

}  // namespace granary::run
