// A case of a sweep of resolved breakage, as a breakage kernel sees it: its settings, what hits its agglomerates, and
// what became of them. The kernel itself: kernel.hpp.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "controller/campaign/campaign.hpp"
#include "estimation/breakage/history.hpp"

namespace granary::sweep {

/// Energy that reaches the particles per sphere and second, from tallies.jsonl: mean over the case [W].
struct Impacts {
  std::map<std::string, double> power;  ///< of each body that turns: torque times speed
  double collisions = 0.0;              ///< of particles with each other: rate times m v^2 / 4, over their speeds
  /// By what breaks: a body's own; "particles": the collisions; what stands still and all others: all bodies'.
  double on(const std::string& cause) const;
};

struct ResolvedCase {
  std::string name;                 ///< "0001"
  std::vector<std::string> values;  ///< of the swept settings
  std::vector<double> ln_setting;   ///< ln of each setting that the law knows
  bool trained = true;              ///< false: held out
  long seed = 0;
  double sphere_volume = 0.0;  ///< of a primary sphere [m^3]
  int spheres = 0;             ///< of an agglomerate
  Impacts impacts;
  estimation::FragmentHistory history;
  std::vector<estimation::SizeRecord> records;
  std::vector<std::vector<estimation::SizeSums>> agglomerates;  ///< of each by itself; empty: not told apart
};

struct KernelOptions {
  enum class By { settings, impacts };
  std::vector<std::string> held_out;  ///< names of cases, or values of settings ("200 rpm"): not fitted, only compared
  double from = 0.0;                  ///< samples before are left out; the balance begins with the first after [s]
};

/// From the lines of tallies.jsonl; mass of a sphere [kg].
Impacts impacts_of(const std::vector<json::Value>& tallies, double sphere_mass);

/// Cases of the sweep that have fragments. Errors: not a sweep of a DEM; no case has any; agglomerates that differ.
Result<std::vector<ResolvedCase>> resolved_cases(const campaign::Campaign& campaign, const std::filesystem::path& dir,
                                                 const KernelOptions& options, std::vector<std::string>& settings);

}  // namespace granary::sweep
