#include "controller/sweep/resolved_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/json/io.hpp"
#include "common/units.hpp"
#include "controller/sweep/cases.hpp"
#include "controller/sweep/results.hpp"

namespace granary::sweep {
namespace {

namespace fs = std::filesystem;
using campaign::Campaign;
using campaign::Sweep;
using campaign::SweepCase;

bool is_held_out(const ResolvedCase& one, const std::vector<std::string>& held_out) {
  return std::any_of(held_out.begin(), held_out.end(), [&](const std::string& word) {
    return word == one.name || std::find(one.values.begin(), one.values.end(), word) != one.values.end();
  });
}

Result<ResolvedCase> read_resolved(const SweepCase& from, const fs::path& folder, const KernelOptions& options) {
  const dem::Agglomerates& put_in = *from.understood->dem_case.agglomerates;
  ResolvedCase one;
  one.name = from.name;
  one.spheres = put_in.spheres;
  one.sphere_volume = kPi / 6.0 * std::pow(put_in.sphere_diameter, 3);
  one.seed = from.understood->dem_case.seed;
  for (const json::Value& value : from.values) one.values.push_back(text_of(value));
  const fs::path file = folder / "fragments.jsonl";
  GRANARY_TRY(const auto lines, json::LineReader(file).next());
  GRANARY_TRY(one.history, estimation::history_of(lines, file.string()));
  const auto apart = estimation::by_agglomerate(one.history, one.spheres);
  const auto from_time = [&](estimation::FragmentHistory history) {
    std::erase_if(history, [&](const estimation::FragmentSample& sample) { return sample.time < options.from; });
    if (!history.empty()) history.front().splits.clear();  // they came before
    return history;
  };
  one.history = from_time(std::move(one.history));
  GRANARY_TRY(const auto tallies, json::LineReader(folder / "tallies.jsonl").next());
  one.impacts = impacts_of(tallies, one.sphere_volume * from.understood->dem_case.density);
  const auto bounds = estimation::size_bounds(one.spheres);
  one.records = estimation::records_of(one.history, bounds);
  for (const auto& agglomerate : apart) one.agglomerates.push_back(estimation::sums_of(from_time(agglomerate), bounds));
  one.trained = !is_held_out(one, options.held_out);
  return one;
}

bool broke(const ResolvedCase& one) {
  return std::any_of(one.records.begin(), one.records.end(),
                     [](const estimation::SizeRecord& record) { return record.all_splits() > 0; });
}

/// The settings that are positive numbers, and of which the trained cases in which anything broke have several.
std::vector<std::size_t> conditions(const Campaign& campaign, const std::vector<ResolvedCase>& cases) {
  std::vector<std::size_t> known;
  for (std::size_t k = 0; k < campaign.sweep.settings.size(); ++k) {
    if (campaign.sweep.settings[k].pointer == campaign::kSeedSetting) continue;  // a repetition is no condition
    std::set<double> values;
    bool numbers = true;
    for (const ResolvedCase& one : cases) {
      const auto value = leading_number(one.values[k]);
      numbers = numbers && value && *value > 0.0;
      if (value && one.trained && broke(one)) values.insert(*value);
    }
    if (numbers && values.size() > 1) known.push_back(k);
  }
  return known;
}

/// sum over the bins of a histogram of speeds: count times v^2, at the bins' geometric means [m^2/s^2].
double sum_of_squares(const std::vector<double>& histogram, const std::vector<double>& edges) {
  double sum = 0.0;
  for (std::size_t b = 0; b + 1 < edges.size() && b < histogram.size(); ++b)
    sum += histogram[b] * edges[b] * edges[b + 1];
  return sum;
}

}  // namespace

double Impacts::on(const std::string& cause) const {
  if (cause == "particles") return collisions;
  if (const auto own = power.find(cause); own != power.end()) return own->second;
  double all = 0.0;
  for (const auto& [body, watts] : power) all += watts;
  return all;
}

Impacts impacts_of(const std::vector<json::Value>& tallies, double sphere_mass) {
  Impacts impacts;
  std::vector<double> edges;
  double time = 0.0;
  for (const json::Value& line : tallies) {
    if (edges.empty() && line["speed_edges_m_s"].is_array()) edges = line["speed_edges_m_s"].numbers();
    const double window = line.number_or("window_s", 0.0);
    if (!line["particles"].is_array() || !(window > 0.0)) continue;
    double spheres = 0.0;
    for (const json::Value& compartment : line["particles"].items())
      for (const double n : compartment.numbers()) spheres += n;
    if (!(spheres > 0.0)) continue;
    time += window;
    impacts.collisions +=
        0.25 * sphere_mass * sum_of_squares(line["collision_speed"]["histogram"].numbers(), edges) / spheres;
    for (const auto& [body, load] : line["loads"].members_or_none())
      impacts.power[body] += window * load.number_or("power_W", 0.0) / spheres;
  }
  if (!(time > 0.0)) return {};
  impacts.collisions /= time;
  for (auto& [body, watts] : impacts.power) watts /= time;
  return impacts;
}

Result<std::vector<ResolvedCase>> resolved_cases(const Campaign& campaign, const fs::path& dir,
                                                 const KernelOptions& options, std::vector<std::string>& settings) {
  if (campaign.kind != campaign::Kind::sweep || campaign.sweep.solver != Sweep::Solver::dem)
    return Error{dir.string() + ": this is no sweep of a DEM with agglomerates."};
  std::vector<ResolvedCase> cases;
  for (const SweepCase& from : campaign.sweep.cases) {
    GRANARY_TRY(ResolvedCase one, read_resolved(from, dir / folder_of(from), options));
    if (one.history.size() > 1) cases.push_back(std::move(one));
  }
  if (cases.empty()) return Error{dir.string() + ": no case has fragments yet. Run it: granary resume " + dir.string()};
  for (const ResolvedCase& one : cases)
    if (one.spheres != cases.front().spheres)
      return Error{
          fmt::format("{}: case {} has agglomerates of {} spheres, case {} of {}: one kernel cannot be both's.",
                      dir.string(), cases.front().name, cases.front().spheres, one.name, one.spheres)};
  settings.clear();
  for (const std::size_t k : conditions(campaign, cases)) {
    settings.push_back(campaign.sweep.settings[k].name);
    for (ResolvedCase& one : cases) one.ln_setting.push_back(std::log(*leading_number(one.values[k])));
  }
  return cases;
}

}  // namespace granary::sweep
