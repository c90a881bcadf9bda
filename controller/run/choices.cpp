#include "controller/run/choices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "common/json/io.hpp"
#include "dem_templates/render/time_step.hpp"

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

/// [s since 1970]
double written_at(const fs::path& file) {
  std::error_code ignored;
  const auto written = std::chrono::file_clock::to_sys(fs::last_write_time(file, ignored));
  return std::chrono::duration<double>(written.time_since_epoch()).count();
}

/// What the bursts ran with, from their own files.
struct BurstFigures {
  double least_step = 1e300, most_step = 0.0, least_contact_steps = 1e300, least_modulus = 1e300;
  double resize_volume_error = 0.0, overlap_left = 0.0;
  std::vector<double> overhead;  ///< from the last output of the balance to the first steps of the DEM [s]
};

Result<BurstFigures> figures_of(const fs::path& dir, const coupling::State& state) {
  BurstFigures figures;
  std::optional<coupling::BurstId> previous;
  for (const auto& over : state.bursts) {
    const auto before = std::exchange(previous, over.burst);
    if (over.burst.kind != coupling::Kind::dem) continue;
    const fs::path folder = dir / "bursts" / over.burst.folder();
    GRANARY_TRY(const json::Value document, json::read_file(folder / "case.json"));
    GRANARY_TRY(const dem::DemCase burst, dem::read_case(document, (folder / "case.json").string()));
    figures.least_step = std::min(figures.least_step, burst.time_step);
    figures.most_step = std::max(figures.most_step, burst.time_step);
    figures.least_contact_steps =
        std::min(figures.least_contact_steps, 1.0 / dem::time_step_figures(burst).contact_share);
    figures.least_modulus = std::min(figures.least_modulus, burst.contact.young_modulus);
    if (!fs::exists(folder / "resize.json")) continue;  // stopped before it began
    GRANARY_TRY(const json::Value resized, json::read_file(folder / "resize.json"));
    const double asked = resized.number_or("asked_volume_m3", 0.0);
    figures.resize_volume_error =
        std::max(figures.resize_volume_error, std::abs(resized["after"].number_or("volume_m3", 0.0) / asked - 1.0));
    const double began = resized.number_or("first_steps_unix_s", 0.0);
    if (began > 0.0 && before && before->kind == coupling::Kind::pbm)
      figures.overhead.push_back(began - written_at(dir / "bursts" / before->folder() / "out.h5"));
    figures.overlap_left = std::max(figures.overlap_left, resized.number_or("overlap_left", 0.0));
  }
  return figures;
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
  GRANARY_TRY(const BurstFigures bursts, figures_of(dir, state));
  double counting = 0.0;
  for (const DemRates& rates : results.rates) counting = std::max(counting, counting_error(rates));
  choices.push_back(
      {"DEM burst length",
       fmt::format("at most {:g} s, first {:g} s not used", campaign.dem.longest_burst, campaign.coupling.grace),
       fmt::format("counting error of a collision rate at most {:.1f} % (measured)", 100.0 * counting),
       "proportional to the length"});
  choices.push_back({"DEM time step",
                     fmt::format("{}{:.2g} to {:.2g} s", campaign.dem.time_step ? "" : "automatic, ", bursts.least_step,
                                 bursts.most_step),
                     fmt::format("fastest contacts resolved by {:.0f} steps at least; effect on the kernel: "
                                 "granary bench dem",
                                 bursts.least_contact_steps),
                     "inversely proportional"});
  choices.push_back(
      {"DEM stiffness",
       fmt::format("{:.3g} Pa{}", bursts.least_modulus,
                   campaign.dem.soft_overlap ? ", softened" : ", as the material's"),
       fmt::format("largest overlap {:.1f} % of a radius (measured); effect on the kernel: granary bench dem",
                   100.0 * largest(results.dem.largest_overlap)),
       "time step grows as its power -2/5"});
  choices.push_back(
      {"DEM hold-up", "filled at once, resized from the population balance between bursts",
       fmt::format("hold-up volume kept within {:.1e}; overlaps of at most {:.1f} % of a radius left "
                   "by a resize; bed settles for {:g} s (measured)",
                   bursts.resize_volume_error, 100.0 * bursts.overlap_left, campaign.dem_case.settle_time),
       "instead of feeding it for residence times"});
  if (!bursts.overhead.empty()) {
    std::vector<double> sorted = bursts.overhead;
    std::sort(sorted.begin(), sorted.end());
    choices.push_back({"DEM restart",
                       fmt::format("from the last state and the balance's last output, {} times", sorted.size()),
                       "none: a run cut by a restart goes on to the bit (tested)",
                       fmt::format("{:.2g} s from one burst's last output to the next one's first steps (median), "
                                   "{:.2g} s at most (measured)",
                                   sorted[sorted.size() / 2], sorted.back())});
  }
  choices.push_back(
      {"DEM walls", campaign.dem_case.walls == dem::Walls::granary ? "granary/wall" : "LIGGGHTS' own",
       "forces equal to 1e-11 on standing walls (a test of the build, not of this run)",
       campaign.dem_case.walls == dem::Walls::granary ? "6 to 10 times faster steps in the bench" : "slower"});
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
