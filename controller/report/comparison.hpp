// Campaigns side by side: what differs in their settings, in what they say of the granules, and in what they cost.
#pragma once

#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "common/results/campaign_results.hpp"
#include "controller/report/plotter.hpp"

namespace granary::report {

/// How far a quantity is from the reference's over the process: |a - b| / |b|, over the compartments and the
/// reference's times in which both campaigns were.
struct Difference {
  double mean = 0.0;     ///< [-]
  double largest = 0.0;  ///< [-]
};

/// One campaign at the process time they are compared at. NaN: its results do not hold it.
struct Compared {
  std::string name;                   ///< of its folder
  std::vector<std::string> settings;  ///< that differ from the reference's: "/dem/particles 5000 -> 10000"
  std::string ended;                  ///< steady | limit | stopped | failed
  double process_end = 0.0;           ///< [s]
  double wall = 0.0;                  ///< of the whole campaign [s]
  double core_seconds = 0.0;          ///< that its tasks occupied [core s]
  int dem_bursts = 0, pbm_bursts = 0;
  double outlet_d10 = 0.0, outlet_d50 = 0.0, outlet_d90 = 0.0;  ///< of what flows out; [m]
  double number = 0.0;                                          ///< particles in all compartments [-]
  double collisions = 0.0;  ///< of a simulated particle with others, mean over the DEM clock [1/s]
  double impacts = 0.0;     ///< on moving bodies, likewise [1/s]
  Difference d50, number_of_compartments;
};

struct Comparison {
  double at = 0.0;             ///< process time [s]
  std::vector<Compared> runs;  ///< the first is the reference
};

struct NamedResults {
  std::string name;
  CampaignResults results;
};

/// At `at` [s], or (NaN) where the first of them ends. Errors: fewer than two; one without a PBM; a time that one of
/// them did not reach.
Result<Comparison> compare(const std::vector<NamedResults>& runs, double at);

/// The settings that differ: each pointer with what stands there, as "/a/b 1 -> 2", in the order of the first.
std::vector<std::string> differing_settings(const json::Value& reference, const json::Value& other);

/// For a terminal: one line a run with the difference from the reference beside each figure, then the settings.
std::string table(const Comparison& comparison);
json::Value to_json(const Comparison& comparison);
/// d50 of what flows out over the process, a line a run.
Plot outlet_plot(const std::vector<NamedResults>& runs);

}  // namespace granary::report
