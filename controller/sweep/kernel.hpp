// From a sweep of resolved breakage to the breakage kernel of a population balance: a law for the selection rate over
// size and settings, the daughters, and a table file for each case. The fits are estimation/breakage's.
// How good it is: kernel_check.hpp.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/sweep/resolved_case.hpp"
#include "estimation/breakage/daughters.hpp"
#include "estimation/breakage/selection_law.hpp"
#include "pbm_solver/case/pbm_case.hpp"

namespace granary::sweep {

/// rate = sum over causes of exp(c_0 + c_1 ln(n/N) + c_2 ln^2(n/N) + sum_k c_k ln(setting_k)), or, by impacts, with one
/// c ln(P), P the power [W] that what breaks gives each sphere, instead of the settings: known of a case that was run.
/// Daughters are means over the splits by each cause in the fitted cases: the nearer a case's settings (or power), the
/// more it counts, with the weight exp(-1/2 (distance of the logarithms / kNear)^2).
struct BreakageKernel {
  static constexpr double kNear = 0.35;  // of 0.2, 0.35 and 0.6 the best for held-out cases (docs/breakage.md)
  struct SplitsOfCase {
    std::vector<double> at;  ///< ln of the settings, or of the power
    std::vector<estimation::Split> splits;
  };
  struct CauseLaw {
    std::string cause;  ///< "chopper"; "others": of those with too few splits for a law of their own
    long splits = 0;
    estimation::SelectionLaw law;
    std::vector<std::vector<double>> replicas;  ///< coefficients of each draw of the bootstrap; empty: there was none
    std::vector<SplitsOfCase> seen;             ///< by this cause
    /// 95 % of coefficient j: of the bootstrap, or of the likelihood.
    std::pair<double, double> interval(std::size_t j) const;
  };
  KernelOptions::By by = KernelOptions::By::settings;
  std::vector<std::string> settings;  ///< that the law knows
  int spheres = 0;                    ///< N
  std::vector<int> bounds;            ///< of the classes of sizes
  std::vector<CauseLaw> causes;
  std::vector<long> splits;  ///< in each class

  estimation::Rate rate(double size, const ResolvedCase& one) const;  ///< with its 95 % interval
  /// The table for one case's settings: the causes' daughters in proportion to their rates.
  pbm::BreakageTable table(const ResolvedCase& one) const;
};

/// Fitted to the cases that are not held out. Errors: nothing broke; settings that the cases do not tell apart.
Result<BreakageKernel> fit_kernel(const std::vector<ResolvedCase>& cases, const std::vector<std::string>& settings,
                                  KernelOptions::By by);
/// What its coefficients stand before: "1", "ln(spheres/37)", ...
std::vector<std::string> features_of(const BreakageKernel& kernel);

/// kernel.json: the law with its intervals. A kernel file (docs/exchange_formats.md) of one case.
json::Value to_json(const BreakageKernel& kernel);
json::Value kernel_file(const BreakageKernel& kernel, const ResolvedCase& one);

}  // namespace granary::sweep
