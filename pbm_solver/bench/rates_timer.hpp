// The right-hand side of the solver at a fixed state, as often as asked: the one place of the bench that knows how
// states are laid out.
#pragma once

#include <memory>
#include <vector>

#include "pbm_solver/bench/reference_solver.hpp"
#include "pbm_solver/time/compartment_row.hpp"
#include "pbm_solver/time/snapshot.hpp"

namespace granary::pbm::bench {

class SolverRates {
 public:
  /// `exchange` must outlive it.
  SolverRates(const PbmCase& pbm_case, const Snapshot& at, Exchange& exchange, int threads);

  /// All mechanisms of all compartments of this rank, as a step of a run does it. Collective.
  void evaluate();
  /// What a run does now and then, when liquid or sizes have moved: works out again what the kernel takes from them.
  void refresh();
  /// What the last evaluate() gave; of this rank's compartments, shape (X of this rank, n_classes) each.
  ReferenceState rates() const;

 private:
  std::unique_ptr<ModelTables> tables_;  ///< the row points into it
  CompartmentRow row_;
  Inputs inputs_;
  LaneVector state_, rates_;
};

}  // namespace granary::pbm::bench
