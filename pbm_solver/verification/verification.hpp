// Runs the cases with exact solutions and judges the errors.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pbm_solver/verification/verification_case.hpp"

namespace granary::pbm {

/// A case on one grid: its errors, their bounds, its cost.
struct Verification {
  std::string name, group, text, reason;
  int bins = 0;            ///< classes along each solid that is there
  double tolerance = 0.0;  ///< of the time steps
  Comparison errors;
  double l1_bound = 0.0;  ///< NaN: none on this grid
  NamedErrors moment_bounds;
  double order = 0.0;  ///< since the grid before it; NaN: none
  Drift drift;         ///< of the balance of each conserved quantity, with what left the grid
  double drift_bound = 0.0;
  double least_number = 0.0;  ///< smallest number in any class over the number of all
  std::int64_t steps = 0, rejected = 0, rhs_evaluations = 0;
  double cpu = 0.0;  ///< [s]
  bool passed = false;

  double largest_drift() const;
  /// NaN if there is none of this name.
  double moment(const std::string& name) const;
  double moment_bound(const std::string& name) const;
  /// What is beyond its bound, in words; empty: passed.
  std::vector<std::string> faults() const;
};

std::vector<std::string> verification_names();

/// One case on one grid.
/// Errors: unknown name (with a suggestion), bins beyond [2, 256]; a solver that cannot keep its tolerance.
Result<Verification> verify(const std::string& name, int bins, double relative_tolerance = 1e-5);
/// One case on its grids, or on `bins` alone.
Result<std::vector<Verification>> verify_grids(const std::string& name, std::optional<int> bins,
                                               double relative_tolerance = 1e-5);

json::Value to_json(const Verification& verification);

}  // namespace granary::pbm
