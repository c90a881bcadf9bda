#include "controller/campaign/checks.hpp"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>

#include "common/json/io.hpp"
#include "common/math/size_distribution.hpp"
#include "controller/campaign/pointer.hpp"
#include "controller/campaign/powder.hpp"
#include "controller/campaign/sections.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/render/automatic.hpp"
#include "dem_templates/render/time_step.hpp"

namespace granary::campaign {
namespace {

/// Adds problems of one campaign, with the value at the place as it was written.
class Checker {
 public:
  Checker(const Campaign& campaign, json::Problems& problems)
      : campaign_(campaign), file_(campaign.file.string()), problems_(problems) {}

  /// Whether none of these settings (nor the sections they are in, nor anything in them) has a problem yet.
  bool sound(std::initializer_list<std::string> pointers) const {
    for (const json::Problem& problem : problems_.list())
      for (const std::string& pointer : pointers)
        if (problem.file == file_ && (is_within(problem.pointer, pointer) || is_within(pointer, problem.pointer)))
          return false;
    return true;
  }

  void add(const std::string& pointer, std::string message, std::string hint) {
    const json::Value* found = find(campaign_.document, pointer);
    const std::string value = found == nullptr || found->is_object() || found->is_array() ? "" : json::dump(*found);
    problems_.add({file_, pointer, value, std::move(message), std::move(hint)});
  }

 private:
  const Campaign& campaign_;
  std::string file_;
  json::Problems& problems_;
};

bool needs_dem(const pbm::PbmCase& balance) {
  const bool rates = balance.aggregation && balance.aggregation->kernel == pbm::Aggregation::Kernel::dem;
  const bool impacts = balance.breakage && balance.breakage->selection == pbm::Breakage::Selection::impact;
  return rates || impacts;
}

void check_mode(const Campaign& campaign, Checker& checker) {
  if (!checker.sound({"/coupling/mode", "/pbm/aggregation", "/pbm/breakage"})) return;
  const pbm::PbmCase& balance = campaign.pbm_case;
  if (campaign.coupling.mode != CouplingSettings::Mode::pbm_only) {
    if (!needs_dem(balance))
      checker.add("/coupling/mode", "nothing of the PBM takes anything from the DEM.",
                  R"(Give /pbm/aggregation a "dem" kernel or /pbm/breakage an "impact" selection, )"
                  R"(or set the mode to "pbm-only".)");
    return;
  }
  if (balance.aggregation && balance.aggregation->kernel == pbm::Aggregation::Kernel::dem)
    checker.add("/pbm/aggregation/kernel", "it takes its rates from a DEM, and in the mode \"pbm-only\" there is none.",
                "Use table, shear, constant, sum or product.");
  if (balance.aggregation && balance.aggregation->efficiency.model == pbm::Efficiency::Model::stokes)
    checker.add("/pbm/aggregation/efficiency/model",
                "stokes (the default) needs the collision speeds of a DEM, and in the mode \"pbm-only\" there is none.",
                "Use constant or wet.");
  if (balance.breakage && balance.breakage->selection == pbm::Breakage::Selection::impact)
    checker.add("/pbm/breakage/selection", "it takes impacts from a DEM, and in the mode \"pbm-only\" there is none.",
                "Use constant or linear.");
}

void check_machine(const Campaign& campaign, Checker& checker) {
  const dem::Machine& machine = campaign.dem_case.machine;
  const auto narrower = [&](const char* inner, double inner_value, const char* outer, double outer_value) {
    const std::string place = std::string("/machine/") + inner, other = std::string("/machine/") + outer;
    if (checker.sound({place, other}) && inner_value >= outer_value)
      checker.add(place, fmt::format("it must be smaller than the {} of {:g} m.", outer, outer_value),
                  "See " + other + ".");
  };
  if (machine.type == dem::Machine::Type::cm5) {
    const dem::HorizontalMixer& mixer = machine.mixer;
    narrower("shaft_diameter", mixer.shaft_diameter, "impeller_diameter", mixer.impeller_diameter);
    narrower("impeller_diameter", mixer.impeller_diameter, "inlet_diameter", mixer.inlet_diameter);
    narrower("shaft_length", mixer.shaft_length, "length", mixer.length);
  } else {
    const dem::BatchBowl& bowl = machine.bowl;
    narrower("impeller_diameter", bowl.impeller_diameter, "bottom_diameter", bowl.bottom_diameter);
    narrower("cylinder_height", bowl.cylinder_height, "cover_height", bowl.cover_height);
    narrower("cover_height", bowl.cover_height, "lid_height", bowl.lid_height);
    if (checker.sound({"/machine/compartments"}) && campaign.pbm_case.compartments.count != 1)
      checker.add("/machine/compartments", "a batch_bowl is one well-mixed compartment.",
                  "Set it to 1 or leave it out.");
  }
}

void check_meshes(const Campaign& campaign, Checker& checker) {
  const dem::Machine& machine = campaign.dem_case.machine;
  const auto mesh = [&](const char* pointer, const std::optional<std::filesystem::path>& file, bool shell) {
    if (!file || !checker.sound({pointer})) return;
    dem::Machine only = machine;
    (shell ? only.impeller_stl : only.shell_stl).reset();
    if (const auto read = dem::bodies(only); !read)
      checker.add(pointer, without_folder(read.error().message, campaign.folder),
                  "Relative paths start at the workflow's folder.");
  };
  mesh("/machine/shell_stl", machine.shell_stl, true);
  mesh("/machine/impeller_stl", machine.impeller_stl, false);
}

void check_flow(const Campaign& campaign, Checker& checker) {
  const pbm::PbmCase& balance = campaign.pbm_case;
  if (!checker.sound({"/feed", "/charge", "/process"})) return;
  const bool batch = campaign.dem_case.machine.type == dem::Machine::Type::batch_bowl;
  if (batch && (balance.feed || balance.compartments.residence_time)) {
    checker.add(balance.feed ? "/feed" : "/process/residence_time", "nothing flows through a batch_bowl.",
                "Remove it, and give a charge.");
    return;
  }
  if (balance.feed && !balance.compartments.residence_time)
    checker.add("/process/residence_time", "there is a feed, so it must be given: nothing would ever leave.",
                "For example \"49 s\".");
  if (!balance.feed && balance.initial.empty())
    checker.add("/process/initial", "there is neither a feed nor anything to start from.", "Give a feed or a charge.");
  if (balance.feed && balance.feed->start >= campaign.duration)
    checker.add("/feed/start", fmt::format("the process is over at {:g} s.", campaign.duration),
                "See /process/duration.");
  if (balance.spray && checker.sound({"/spray"}) && balance.spray->start >= campaign.duration)
    checker.add("/spray/start", fmt::format("the process is over at {:g} s.", campaign.duration),
                "See /process/duration.");
}

void check_times(const Campaign& campaign, Checker& checker) {
  const auto at_most = [&](const std::string& shorter, double value, const std::string& longer, double bound) {
    if (checker.sound({shorter, longer}) && value > bound)
      checker.add(shorter, fmt::format("{:g} s is longer than the {:g} s of {}.", value, bound, longer),
                  "Shorten the one or lengthen the other.");
  };
  const pbm::PbmCase& balance = campaign.pbm_case;
  at_most("/pbm/output_every", balance.output_every, "/pbm/longest_burst", campaign.pbm.longest_burst);
  at_most("/pbm/output_every", balance.output_every, "/process/duration", campaign.duration);
  if (campaign.coupling.mode == CouplingSettings::Mode::pbm_only) return;
  const dem::DemCase& dem = campaign.dem_case;
  at_most("/dem/tally_window", dem.tally.window, "/dem/longest_burst", campaign.dem.longest_burst);
  if (const double looks = dem.time_step * dem.tally.every;
      checker.sound({"/dem/time_step", "/dem/tally_every", "/dem/tally_window"}) && looks > dem.tally.window)
    checker.add(
        "/dem/tally_every",
        fmt::format("a look every {} steps of {:g} s is one in {:g} s, longer than the {:g} s of /dem/tally_window.",
                    dem.tally.every, dem.time_step, looks, dem.tally.window),
        "Take fewer steps between looks, a shorter /dem/time_step (stiffer "
        "particles have one), or a longer window.");
  at_most("/coupling/grace", campaign.coupling.grace, "/dem/longest_burst", campaign.dem.longest_burst);
}

/// What the DEM is filled with first: solids [kg] and volume with gas and liquid [m^3] of all compartments.
struct HoldUp {
  double mass = 0.0, volume = 0.0;
};

HoldUp starting_hold_up(const pbm::PbmCase& balance) {
  std::vector<pbm::ClassRate> classes;
  double fluid = 0.0;
  for (const pbm::InitialClass& filled : balance.initial) {
    classes.push_back({filled.i, filled.j, filled.number * balance.compartments.count});
    fluid += (filled.liquid + filled.gas) * balance.compartments.count;
  }
  if (classes.empty() && balance.feed && balance.compartments.residence_time)
    for (const pbm::ClassRate& fed : balance.feed->classes)
      classes.push_back({fed.i, fed.j, fed.rate * *balance.compartments.residence_time});
  double solid = 0.0;
  for (const pbm::ClassRate& held : classes)
    solid += held.rate * (pivot(balance.grid, 0, held.i) + pivot(balance.grid, 1, held.j));
  if (balance.initial.empty() && balance.feed) fluid = solid * balance.feed->porosity / (1.0 - balance.feed->porosity);
  return {solid_mass(classes, balance.grid, balance.materials), solid + fluid};
}

/// The mean particle at half the budget of particles; nothing where that cannot be told.
std::optional<dem::DemCase> likely_case(const Campaign& campaign) {
  if (campaign.coupling.mode == CouplingSettings::Mode::pbm_only || campaign.dem.coarse_graining) return std::nullopt;
  const HoldUp held = starting_hold_up(campaign.pbm_case);
  if (!(held.volume > 0.0)) return std::nullopt;
  dem::DemCase likely = campaign.dem_case;
  const double diameter = sphere_diameter(held.volume / (0.5 * static_cast<double>(campaign.dem.particles)));
  likely.feed_rate = 0.0;
  likely.density = campaign.dem.density.value_or(held.mass / held.volume);
  likely.population = {{0.0, 1.0, {diameter}, {1}}};
  return likely;
}

/// A burst is held against its own particles when it is rendered; here only a step that is too long for any likely ones
/// is refused.
void check_time_step(const Campaign& campaign, Checker& checker) {
  if (!campaign.dem.time_step) return;
  if (!checker.sound({"/dem", "/feed", "/charge", "/process", "/pbm", "/machine", "/materials"})) return;
  auto asked = likely_case(campaign);
  if (!asked) return;
  dem::DemCase& likely = *asked;
  likely.time_step = *campaign.dem.time_step;
  const double diameter = likely.population.front().diameter.front();
  const double largest = dem::largest_time_step(dem::time_step_figures(likely));
  if (likely.time_step > largest)
    checker.add(
        "/dem/time_step",
        fmt::format("it is too long for the contacts: {:g} DEM particles are about {:.2g} mm large, and stay stable "
                    "and resolved up to {:.2g} s.",
                    static_cast<double>(campaign.dem.particles), diameter * 1e3, largest),
        "Shorten it, or leave it to \"auto\", or use fewer particles or a lower Young's modulus.");
}

void check_rounds(const Campaign& campaign, Checker& checker) {
  const CouplingSettings& coupling = campaign.coupling;
  if (checker.sound({"/coupling/least_rounds", "/coupling/most_rounds"}) &&
      coupling.least_rounds > coupling.most_rounds)
    checker.add("/coupling/least_rounds",
                fmt::format("it is more than the {} of /coupling/most_rounds.", coupling.most_rounds),
                "Lower the one or raise the other.");
  if (checker.sound({"/pbm/ranks", "/machine/compartments"}) &&
      campaign.pbm.ranks > campaign.pbm_case.compartments.count)
    checker.add("/pbm/ranks",
                fmt::format("it is more than the {} of /machine/compartments; a compartment is not divided.",
                            campaign.pbm_case.compartments.count),
                "Use fewer ranks and more /pbm/threads.");
}

}  // namespace

void choose_likely_time_step(Campaign& campaign) {
  if (campaign.dem.time_step) {
    campaign.dem_case.time_step = *campaign.dem.time_step;
  } else if (const auto likely = likely_case(campaign)) {
    campaign.dem_case.time_step = dem::automatic_time_step(*likely);
  }
}

void check_together(const Campaign& campaign, json::Problems& problems) {
  Checker checker(campaign, problems);
  check_mode(campaign, checker);
  check_machine(campaign, checker);
  check_meshes(campaign, checker);
  check_flow(campaign, checker);
  check_times(campaign, checker);
  check_time_step(campaign, checker);
  check_rounds(campaign, checker);
}

void check_dem_alone(const Campaign& campaign, json::Problems& problems) {
  Checker checker(campaign, problems);
  check_machine(campaign, checker);
  check_meshes(campaign, checker);
  const dem::DemCase& dem = campaign.dem_case;
  if (dem.tally.window > dem.duration)
    checker.add("/dem/tally_window", fmt::format("it is longer than the {:g} s of /process/duration.", dem.duration),
                "Shorten the one or lengthen the other.");
  if (dem.agglomerates->sample_every > dem.duration)
    checker.add("/agglomerates/sample_every",
                fmt::format("it is longer than the {:g} s of /process/duration.", dem.duration),
                "Shorten the one or lengthen the other.");
  if (const auto problem = dem::time_step_problem(dem::time_step_figures(dem)))
    checker.add("/dem/time_step", "it is too long: " + *problem, "");
}

void check_cores(const Campaign& campaign, int nodes, int cores_per_node, json::Problems& problems) {
  if (campaign.kind == Kind::sweep) {
    for (const SweepCase& one : campaign.sweep.cases)
      if (one.understood) check_cores(*one.understood, nodes, cores_per_node, problems);
    return;
  }
  Checker checker(campaign, problems);
  const int cores = nodes * cores_per_node;
  const std::string there = nodes == 1 ? fmt::format("the {} there are", cores)
                                       : fmt::format("the {} there are ({} nodes of {})", cores, nodes, cores_per_node);
  const std::string hint = "Lower it, or give more in /resources/cores.";
  if (campaign.coupling.mode != CouplingSettings::Mode::pbm_only && campaign.dem_case.ranks > cores &&
      checker.sound({"/dem/ranks", "/resources"}))
    checker.add("/dem/ranks", fmt::format("a DEM burst needs {} cores, more than {}.", campaign.dem_case.ranks, there),
                hint);
  if (!checker.sound({"/pbm/ranks", "/pbm/threads", "/resources"})) return;
  if (campaign.pbm.threads > cores_per_node)
    checker.add("/pbm/threads",
                fmt::format("the threads of a rank share a node, and a node has {} cores.", cores_per_node), hint);
  else if (campaign.pbm.ranks * campaign.pbm.threads > cores)
    checker.add("/pbm/ranks",
                fmt::format("a PBM burst needs {} cores ({} ranks of {} threads), more than {}.",
                            campaign.pbm.ranks * campaign.pbm.threads, campaign.pbm.ranks, campaign.pbm.threads, there),
                hint);
}

}  // namespace granary::campaign
