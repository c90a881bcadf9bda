#include "controller/coupling/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace granary::coupling {

namespace {

constexpr double kLeastShare = 1e-3;

bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

/// @param error  standard error of after - before
void add(Change& change, std::string what, std::string where, double before, double after, double error) {
  const double denominator = before != 0.0 ? std::abs(before) : std::abs(after);
  if (!std::isfinite(before) || !std::isfinite(after) || denominator == 0.0) return;
  change.differences.push_back(
      {std::move(what), std::move(where), before, after, (after - before) / denominator, error / denominator});
}

double count_error(double rate, double count) { return rate / std::sqrt(std::max(count, 1.0)); }

/// Particles of the d50 in each compartment: only to tell an empty one from a full one.
std::vector<double> rough_volume(const PbmSummary& summary) {
  std::vector<double> volume;
  for (std::size_t x = 0; x < summary.number.size(); ++x)
    volume.push_back(summary.number[x] * std::pow(summary.d50[x], 3));
  return volume;
}

double most(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

const Difference* largest_of(const std::vector<Difference>& all, auto&& counts) {
  const Difference* largest = nullptr;
  for (const Difference& one : all)
    if (counts(one) && (largest == nullptr || std::abs(one.change) > std::abs(largest->change))) largest = &one;
  return largest;
}

}  // namespace

bool DemSummary::operator==(const DemSummary& other) const {
  return start_time == other.start_time && end_time == other.end_time && coarse_graining == other.coarse_graining &&
         particles == other.particles && collision_frequency == other.collision_frequency &&
         impact_frequency == other.impact_frequency && collisions == other.collisions && impacts == other.impacts &&
         same(class_diameter, other.class_diameter) && same(mean_speed, other.mean_speed) &&
         same(mean_speed_error, other.mean_speed_error);
}

const Difference* Change::beyond(double tolerance, double significance) const {
  return largest_of(differences, [&](const Difference& one) {
    return std::abs(one.change) > tolerance && std::abs(one.change) > significance * one.noise;
  });
}

const Difference* Change::largest() const {
  return largest_of(differences, [](const Difference&) { return true; });
}

Change compare(const DemSummary& before, const DemSummary& after) {
  Change change;
  add(change, "collision_frequency", "all", before.collision_frequency, after.collision_frequency,
      std::hypot(count_error(before.collision_frequency, before.collisions),
                 count_error(after.collision_frequency, after.collisions)));
  add(change, "impact_frequency", "all", before.impact_frequency, after.impact_frequency,
      std::hypot(count_error(before.impact_frequency, before.impacts),
                 count_error(after.impact_frequency, after.impacts)));
  if (before.mean_speed.size() != after.mean_speed.size()) return change;
  for (std::size_t p = 0; p < before.mean_speed.size(); ++p)
    add(change, "speed_mean_m_s", fmt::format("class {}", p + 1), before.mean_speed[p], after.mean_speed[p],
        std::hypot(before.mean_speed_error[p], after.mean_speed_error[p]));
  return change;
}

Change compare(const PbmSummary& before, const PbmSummary& after) {
  Change change;
  if (before.number.size() != after.number.size()) return change;
  const std::vector<double> volume_before = rough_volume(before), volume_after = rough_volume(after);
  const double least_before = kLeastShare * most(volume_before), least_after = kLeastShare * most(volume_after);
  for (std::size_t x = 0; x < before.number.size(); ++x) {
    if (volume_before[x] <= least_before && volume_after[x] <= least_after) continue;
    const std::string where = fmt::format("compartment {}", x + 1);
    add(change, "d50_m", where, before.d50[x], after.d50[x], 0.0);
    add(change, "number", where, before.number[x], after.number[x], 0.0);
  }
  return change;
}

Change compare(const CoupledSummary& before, const CoupledSummary& after) {
  Change change = compare(before.dem, after.dem);
  const Change of_pbm = compare(before.pbm, after.pbm);
  change.differences.insert(change.differences.end(), of_pbm.differences.begin(), of_pbm.differences.end());
  return change;
}

json::Value to_json(const Difference& difference) {
  return json::Value::object({{"what", difference.what},
                              {"where", difference.where},
                              {"before", difference.before},
                              {"after", difference.after},
                              {"change", difference.change},
                              {"noise", difference.noise}});
}

json::Value to_json(const DemSummary& summary) {
  return json::Value::object({{"start_time_s", summary.start_time},
                              {"end_time_s", summary.end_time},
                              {"coarse_graining", summary.coarse_graining},
                              {"particles", summary.particles},
                              {"collision_frequency_1_s", summary.collision_frequency},
                              {"impact_frequency_1_s", summary.impact_frequency},
                              {"collisions", summary.collisions},
                              {"impacts", summary.impacts},
                              {"class_diameter_m", summary.class_diameter},
                              {"speed_mean_m_s", summary.mean_speed},
                              {"speed_mean_error_m_s", summary.mean_speed_error}});
}

json::Value to_json(const PbmSummary& summary) {
  return json::Value::object({{"time_s", summary.time}, {"d50_m", summary.d50}, {"number", summary.number}});
}

DemSummary dem_summary_from_json(const json::Value& value) {
  DemSummary summary;
  summary.start_time = value.number_or("start_time_s", 0.0);
  summary.end_time = value.number_or("end_time_s", 0.0);
  summary.coarse_graining = value.number_or("coarse_graining", 1.0);
  summary.particles = value.number_or("particles", 0.0);
  summary.collision_frequency = value.number_or("collision_frequency_1_s", 0.0);
  summary.impact_frequency = value.number_or("impact_frequency_1_s", 0.0);
  summary.collisions = value.number_or("collisions", 0.0);
  summary.impacts = value.number_or("impacts", 0.0);
  summary.class_diameter = value.numbers("class_diameter_m");
  summary.mean_speed = value.numbers("speed_mean_m_s");
  summary.mean_speed_error = value.numbers("speed_mean_error_m_s");
  summary.mean_speed_error.resize(summary.mean_speed.size(), 0.0);
  return summary;
}

PbmSummary pbm_summary_from_json(const json::Value& value) {
  PbmSummary summary{value.number_or("time_s", 0.0), value.numbers("d50_m"), value.numbers("number")};
  summary.d50.resize(summary.number.size(), 0.0);
  return summary;
}

}  // namespace granary::coupling
