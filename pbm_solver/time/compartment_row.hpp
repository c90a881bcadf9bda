// The compartments of one rank as one system of ordinary differential equations, computed by its threads.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "pbm_solver/model/compartment_block.hpp"
#include "pbm_solver/time/exchange.hpp"

namespace granary::pbm {

/// The state is one array of blocks of `lanes()` compartments: in each block numbers, liquid and gas, [class][lane]
/// each, then the ledger [ledger::kSize][lane] (in memory on a cache line: LaneVector), which is integrated with the
/// same weights, so that the balance closes to round-off. Lanes without a compartment are 0 and stay 0.
class CompartmentRow {
 public:
  CompartmentRow(const ModelTables& tables, Exchange& exchange, int threads);

  std::size_t compartments() const { return compartments_; }  ///< of this rank
  std::size_t classes() const { return n_; }
  std::size_t lanes() const { return lanes_; }
  std::size_t blocks() const { return blocks_.size(); }
  std::size_t stride() const { return (3 * n_ + ledger::kSize) * lanes_; }  ///< of a block
  std::size_t size() const { return blocks() * stride(); }
  const ClassGrid& grid() const { return tables_->grid; }
  const ModelTables& tables() const { return *tables_; }
  const CompartmentBlock& block(std::size_t b) const { return blocks_[b]; }

  /// Place in a state of entry e of compartment x: e = q classes() + k for field q (number, liquid, gas) and class k;
  /// from 3 classes() on the ledger.
  std::size_t at(std::size_t x, std::size_t e) const { return x / lanes_ * stride() + e * lanes_ + x % lanes_; }
  /// Place of class k of compartment x in an array with one value a class, [block][class][lane].
  std::size_t by_class(std::size_t x, std::size_t k) const { return (x / lanes_ * n_ + k) * lanes_ + x % lanes_; }
  std::size_t class_values() const { return blocks() * n_ * lanes_; }

  /// Compartment x from and to the plain order: 3 classes() + ledger::kSize values.
  void unpack(std::span<const double> state, std::size_t x, std::span<double> compartment) const;
  void pack(std::span<const double> compartment, std::size_t x, std::span<double> state) const;

  /// Largest error of a low-rank kernel in this rank's compartments, over the collision rate; 0 where kernels are
  /// exact.
  double kernel_error() const;

  /// Before a step from `state`. afresh: what looks at particles is worked out even if none has moved, so that a
  /// restart from here finds the same. Collective.
  void begin_step(std::span<const double> state, bool afresh);
  /// d(state)/dt. Collective over the ranks: one message downstream. The same bits for any number of threads and ranks.
  /// @param participation  empty, or factors [class_values()]
  void rates(std::span<const double> state, std::span<const double> participation, Inputs inputs,
             std::span<double> rates, bool breakage = true);
  /// out += factor A state with the map A of breakage at the last begin_step() or rates().
  void add_breakage(double factor, std::span<const double> state, std::span<double> out);
  /// Solves y - gamma A y = r in place.
  void solve_breakage(double gamma, std::span<double> state);

  /// At the last rates(): loss rate per particle [1/s], [class][lane] of block b.
  std::span<const double> loss_rate(std::size_t b) const { return blocks_[b].loss_rate(); }

  /// each(b) for every block, shared by the threads always in the same way, so that what a core wrote last is near it.
  void for_each_block(const std::function<void(std::size_t)>& each) const;

 private:
  void follow_particles(std::span<const double> state, bool afresh);
  void read_carry(std::span<const double> state, std::size_t b);

  const ModelTables* tables_;
  Exchange* exchange_;
  int threads_;
  std::size_t compartments_, n_, lanes_;
  std::vector<CompartmentBlock> blocks_;
  std::vector<double> upstream_;  ///< state of the compartment above my first: shape (3, n_classes), empty without one
  std::vector<double> last_;      ///< of my last compartment, to send
  std::vector<std::vector<double>> carry_;  ///< what flows into lane 0 of each block
};

}  // namespace granary::pbm
