// The whole state of a run at one time: what a restart needs to go on with the same bits.
#pragma once

#include <vector>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/class_grid.hpp"

namespace granary::pbm {

struct Snapshot {
  double time = 0.0;                ///< [s]
  double next_step = 0.0;           ///< what the step control would try next [s]; 0: not started
  double last_error = 1.0;          ///< of the last step, relative to the tolerance (the step control remembers it)
  std::vector<double> number;       ///< shape (X, n_classes)
  std::vector<double> liquid, gas;  ///< totals of the classes [m^3], shape (X, n_classes)
  std::vector<double> ledger;       ///< shape (X, ledger::kSize)
};

/// The start of a case: its initial classes, or empty.
Snapshot initial_snapshot(const PbmCase& pbm_case, const ClassGrid& grid);

/// Relative error of the balance of solid 1, solid 2, liquid and gas since the start:
///   |held - start - in + out + oversize (+ consolidated)| / (start + in);  0 where nothing ever was.
struct Drift {
  double solid_1 = 0.0, solid_2 = 0.0, liquid = 0.0, gas = 0.0;
};
Drift drift(const Snapshot& snapshot, const ClassGrid& grid);

}  // namespace granary::pbm
