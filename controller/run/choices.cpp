#include "controller/run/choices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/json/io.hpp"

namespace granary::run {
namespace fs = std::filesystem;
namespace {

constexpr const char* kNotMeasured = "not measured";

std::string yes_or_left_out(bool there, const std::string& what) { return there ? what : "left out"; }

/// Largest relative counting error of the class pairs that carry 99 % of the collisions.
double counting_error(const DemRates& rates) {
  double total = 0.0, worst = 0.0;
  for (std::size_t p = 0; p < rates.collisions.size(); ++p)
    for (std::size_t q = 0; q <= p; ++q) total += rates.collisions[p][q];
  for (std::size_t p = 0; p < rates.collisions.size(); ++p)
    for (std::size_t q = 0; q <= p; ++q)
      if (rates.collisions[p][q] >= 0.01 * total) worst = std::max(worst, 1.0 / std::sqrt(rates.collisions[p][q]));
  return worst;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, value);
  return most;
}

void pbm_choices(std::vector<ModelChoice>& choices, const campaign::Campaign& campaign,
                 const CampaignResults& results) {
  const auto& pbm = campaign.pbm_case;
  choices.push_back({"PBM grid",
                     fmt::format("{} x {} classes, volume ratio {:g}, {} compartments", pbm.grid.bins[0],
                                 pbm.grid.bins[1], pbm.grid.ratio[0], pbm.compartments.count),
                     kNotMeasured,
                     fmt::format("work grows with the square of {} classes", pbm.grid.bins[0] * pbm.grid.bins[1])});
  const double drift = std::max({largest(results.pbm.drift_solid_1), largest(results.pbm.drift_solid_2),
                                 largest(results.pbm.drift_liquid), largest(results.pbm.drift_gas)});
  choices.push_back({"PBM time steps", fmt::format("adaptive, local error {:g}", pbm.relative_tolerance),
                     fmt::format("largest drift of a conserved quantity {:.1e} (measured)", drift), kNotMeasured});
  choices.push_back(
      {"Aggregation", yes_or_left_out(pbm.aggregation.has_value(), "modelled"), kNotMeasured, "nothing if left out"});
  choices.push_back(
      {"Breakage", yes_or_left_out(pbm.breakage.has_value(), "modelled"), kNotMeasured, "nothing if left out"});
  choices.push_back({"Consolidation", yes_or_left_out(pbm.consolidation.has_value(), "modelled"), kNotMeasured,
                     "nothing if left out"});
  choices.push_back({"Liquid and gas", "one mean value a class (lumped)", kNotMeasured,
                     "two fields instead of two further dimensions"});
}

Status dem_choices(std::vector<ModelChoice>& choices, const campaign::Campaign& campaign, const fs::path& dir,
                   const coupling::State& state, const CampaignResults& results) {
  if (results.rates.empty()) return {};  // the DEM gave nothing: nothing can be said of its choices
  double tail = 0.0, capped = 0.0, volume_error = 0.0, least_f = 1e300, most_f = 0.0;
  for (const auto& over : state.bursts) {
    if (over.burst.kind != coupling::Kind::dem) continue;
    GRANARY_TRY(const auto sampled, json::read_file(dir / "bursts" / over.burst.folder() / "sampled.json"));
    tail = std::max(tail, sampled.number_or("unrepresented_volume", 0.0));
    capped = std::max(capped, sampled.number_or("capped_volume", 0.0));
    volume_error = std::max(volume_error, sampled.number_or("volume_error", 0.0));
    least_f = std::min(least_f, sampled.number_or("coarse_graining", 1.0));
    most_f = std::max(most_f, sampled.number_or("coarse_graining", 1.0));
  }
  choices.push_back(
      {"DEM particle number",
       fmt::format("coarse-grained {:.3g} to {:.3g} times in diameter, budget {}", least_f, most_f,
                   campaign.dem.particles),
       fmt::format("hold-up volume kept within {:.1e}; up to {:.0f} % of it is finer than the finest class and {:.0f} "
                   "% coarser than "
                   "the machine's gaps allow, both shown at the bound (measured); effect on the kernel not measured",
                   volume_error, 100.0 * tail, 100.0 * capped),
       fmt::format("{:.1e} times fewer particles", most_f * most_f * most_f)});
  double counting = 0.0;
  for (const DemRates& rates : results.rates) counting = std::max(counting, counting_error(rates));
  choices.push_back(
      {"DEM burst length",
       fmt::format("at most {:g} s, first {:g} s not used", campaign.dem.longest_burst, campaign.coupling.grace),
       fmt::format("counting error of a collision rate at most {:.1f} % (measured)", 100.0 * counting),
       "proportional to the length"});
  choices.push_back({"DEM time step", fmt::format("{:g} s", campaign.dem_case.time_step),
                     fmt::format("largest overlap {:.1f} % of a radius (measured); effect on the kernel not measured",
                                 100.0 * largest(results.dem.largest_overlap)),
                     "inversely proportional"});
  choices.push_back({"DEM stiffness", fmt::format("{:g} Pa", campaign.dem_case.contact.young_modulus), kNotMeasured,
                     "time step grows as its inverse root"});
  choices.push_back({"Particle shape", "spheres", kNotMeasured, kNotMeasured});
  choices.push_back({"Liquid bridges in the DEM", "left out", kNotMeasured, "nothing"});
  choices.push_back({"Coupling threshold", fmt::format("{:g} %", 100.0 * campaign.coupling.threshold), kNotMeasured,
                     "fewer bursts for a larger one"});
  return {};
}

}  // namespace

Result<std::vector<ModelChoice>> choices_of(const campaign::Campaign& campaign, const fs::path& dir,
                                            const coupling::State& state, const CampaignResults& results) {
  std::vector<ModelChoice> choices;
  pbm_choices(choices, campaign, results);
  if (campaign.coupling.mode != campaign::CouplingSettings::Mode::pbm_only)
    GRANARY_CHECK(dem_choices(choices, campaign, dir, state, results));
  return choices;
}

}  // namespace granary::run
