// From a sweep of resolved breakage to the breakage kernel of a population balance: a law for the selection rate over
// size and settings, the daughters, and a table file for each case. The fits are estimation/breakage's.
// How good it is: kernel_check.hpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/campaign/campaign.hpp"
#include "estimation/breakage/daughters.hpp"
#include "estimation/breakage/history.hpp"
#include "estimation/breakage/selection_law.hpp"
#include "pbm_solver/case/pbm_case.hpp"

namespace granary::sweep {

/// A case with what its agglomerates became.
struct ResolvedCase {
  std::string name;                 ///< "0001"
  std::vector<std::string> values;  ///< of the swept settings
  std::vector<double> ln_setting;   ///< ln of each setting that the law knows
  bool trained = true;              ///< false: held out
  long seed = 0;
  double sphere_volume = 0.0;  ///< of a primary sphere [m^3]
  int spheres = 0;             ///< of an agglomerate
  estimation::FragmentHistory history;
  std::vector<estimation::SizeRecord> records;
};

struct KernelOptions {
  std::vector<std::string> held_out;  ///< names of cases, or values of settings ("200 rpm"): not fitted, only compared
  double from = 0.0;                  ///< samples before are left out; the balance begins with the first after [s]
};

/// rate = sum over causes of exp(c_0 + c_1 ln(n/N) + c_2 ln^2(n/N) + sum_k c_k ln(setting_k))
struct BreakageKernel {
  struct CauseLaw {
    std::string cause;  ///< "chopper"; "others": of those with too few splits for a law of their own
    long splits = 0;
    estimation::SelectionLaw law;
  };
  std::vector<std::string> settings;  ///< that the law knows
  int spheres = 0;                    ///< N
  std::vector<int> bounds;            ///< of the classes of sizes
  std::vector<CauseLaw> causes;
  std::vector<std::vector<estimation::MeanDaughter>> daughters;  ///< of each class
  std::vector<long> splits;                                      ///< they were seen in

  estimation::Rate rate(double size, const std::vector<double>& ln_setting) const;
  /// The table for one case's settings.
  pbm::BreakageTable table(const ResolvedCase& one) const;
};

/// Cases of the sweep that have fragments. Errors: not a sweep of a DEM; no case has any; agglomerates that differ.
Result<std::vector<ResolvedCase>> resolved_cases(const campaign::Campaign& campaign, const std::filesystem::path& dir,
                                                 const KernelOptions& options, std::vector<std::string>& settings);

/// Fitted to the cases that are not held out. Errors: nothing broke; settings that the cases do not tell apart.
Result<BreakageKernel> fit_kernel(const std::vector<ResolvedCase>& cases, const std::vector<std::string>& settings);

/// kernel.json: the law with its intervals. A kernel file (docs/exchange_formats.md) of one case.
json::Value to_json(const BreakageKernel& kernel);
json::Value kernel_file(const BreakageKernel& kernel, const ResolvedCase& one);

}  // namespace granary::sweep
