// granary-pbm verify: the solver against exact solutions, with the errors, the cost and the best figures known.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pbm_solver/case/pbm_case.hpp"

namespace granary::pbm {

/// A run against an exact solution at its end.
struct Verification {
  std::string name;
  std::string text;           ///< what is solved, in a line
  int bins = 0;               ///< classes along each solid that is there
  double l1_number = 0.0;     ///< sum |N - exact| / sum exact, over the cells
  double l1_volume = 0.0;     ///< the same with the solid volume of the cells
  double moment_0 = 0.0;      ///< relative error of the total number
  double moment_1 = 0.0;      ///< of the solid volume of component 1
  double moment_2 = 0.0;      ///< of the sum of its squares
  double drift = 0.0;         ///< of the balance of solids
  double least_number = 0.0;  ///< smallest number in any class: never negative
  long steps = 0, rhs_evaluations = 0;
  double cpu = 0.0;                  ///< [s]
  std::optional<double> best_known;  ///< l1_number of a plain cell average code at these bins (docs/pbm_equations.md)
};

/// Names of all cases: constant-1d, sum-1d, constant-2d, sum-2d, breakage.
std::vector<std::string> verification_names();

/// Errors: unknown name (with a suggestion); a solver that cannot keep its tolerance.
Result<Verification> verify(const std::string& name, std::optional<int> bins, double relative_tolerance = 1e-5);

json::Value to_json(const Verification& verification);

}  // namespace granary::pbm
