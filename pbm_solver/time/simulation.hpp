// A run of one case in memory: the state, the clock, and going on to a given time. Files and signals are its caller's.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "pbm_solver/time/compartment_row.hpp"
#include "pbm_solver/time/exchange.hpp"
#include "pbm_solver/time/integrator.hpp"
#include "pbm_solver/time/snapshot.hpp"

namespace granary::pbm {

class Simulation {
 public:
  /// Starts from a snapshot of the same grid and number of compartments. `exchange` must outlive it.
  Simulation(const PbmCase& pbm_case, const Snapshot& start, Exchange& exchange, int threads);

  double time() const { return time_; }
  double next_step() const { return next_step_; }
  /// See CompartmentRow::kernel_error(); of this rank.
  double kernel_error() const { return row_.kernel_error(); }
  const WorkCount& work() const { return integrator_.work(); }
  const ClassGrid& grid() const { return tables_->grid; }
  const PbmCase& pbm_case() const { return tables_->pbm_case; }

  /// Integrates to `until` exactly, ending steps also where feed or spray are switched. Collective. After each step
  /// `go_on` is asked (on every rank, with the same answer); false ends early. Returns whether `until` was reached.
  Result<bool> advance(
      double until, const std::function<bool()>& go_on = [] { return true; });

  /// The state of all compartments, on every rank. Collective.
  Snapshot snapshot();

 private:
  double next_switch(double until) const;
  std::size_t values_per_compartment() const { return 3 * row_.classes() + ledger::kSize; }
  /// The lists of a snapshot in the order of a compartment's values, each with its values per compartment.
  template <class AnySnapshot>
  auto lists_of(AnySnapshot& s) const {
    return std::array{std::pair(&s.number, row_.classes()), std::pair(&s.liquid, row_.classes()),
                      std::pair(&s.gas, row_.classes()), std::pair(&s.ledger, std::size_t{ledger::kSize})};
  }

  std::unique_ptr<ModelTables> tables_;  ///< the row points into it
  Exchange* exchange_;
  CompartmentRow row_;
  Integrator integrator_;
  LaneVector state_;
  double time_;
  double next_step_;
};

}  // namespace granary::pbm
