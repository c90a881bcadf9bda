// The compartments of one rank as one system of ordinary differential equations, computed by its threads.
#pragma once

#include <span>
#include <vector>

#include "pbm_solver/model/compartment.hpp"
#include "pbm_solver/time/exchange.hpp"

namespace granary::pbm {

/// The state is one array: for each compartment of this rank its numbers, liquid and gas (n_classes each), then its
/// ledger (ledger::kSize), which is integrated with the same weights, so that the balance closes to round-off.
class CompartmentRow {
 public:
  CompartmentRow(const ModelTables& tables, Exchange& exchange, int threads);

  std::size_t compartments() const { return compartments_.size(); }
  std::size_t classes() const { return n_; }
  std::size_t stride() const { return 3 * n_ + ledger::kSize; }
  std::size_t size() const { return compartments() * stride(); }
  const ClassGrid& grid() const { return tables_->grid; }
  /// Numbers, liquid and gas of compartment x within a state.
  Fields fields(std::span<const double> state, std::size_t x) const;

  /// d(state)/dt. Collective over the ranks: one message downstream. The same bits for any number of threads and ranks.
  /// @param participation  see ActiveClasses::assign; empty, or shape (compartments, n_classes)
  void rates(std::span<const double> state, std::span<const double> participation, Inputs inputs,
             std::span<double> rates);
  /// Loss rate per particle at the last rates(), by compartment and class [1/s].
  std::span<const double> loss_rate(std::size_t x) const { return compartments_[x].loss_rate(); }

 private:
  void prepare(std::span<const double> state, std::span<const double> participation, int x);
  void finish(std::span<const double> state, Inputs inputs, int x, std::span<double> rates);

  const ModelTables* tables_;
  Exchange* exchange_;
  int threads_;
  std::size_t n_;
  std::vector<Compartment> compartments_;
  std::vector<double> upstream_;  ///< state of the compartment above my first: shape (3, n_classes), empty without one
};

}  // namespace granary::pbm
