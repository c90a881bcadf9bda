// The sum of all mechanisms in a block of compartments: d(state)/dt and what flows in and out. No ranks, no files, no
// time.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pbm_solver/model/model_tables.hpp"
#include "pbm_solver/model/particles.hpp"
#include "pbm_solver/model/selection_function.hpp"

namespace granary::pbm {

/// The compartments in the lanes of one block. State and rates of a block: number, liquid and gas, [class][lanes] each,
/// then the ledger [kSize][lanes]; lanes without a compartment stay 0.
class CompartmentBlock {
 public:
  /// Compartments first .. first + count - 1 of the row, count <= tables.lanes.
  CompartmentBlock(const ModelTables& tables, int first, int count);

  std::size_t stride() const { return (3 * n_ + ledger::kSize) * lanes_; }

  /// Before a step from `state`: what is held fixed during a step (which classes are wet) is looked up anew.
  void begin_step(const double* state);
  /// Whether kernels or selection rates depend on liquid and gas.
  bool looks_at_particles() const { return by_particles_; }
  /// Whether they look at particles that have moved by more than kernel_tolerance since they were
  /// last looked at.
  bool moved(const double* state) const;
  void look_at_particles(const double* state);

  /// d(state)/dt, overwritten.
  /// @param participation  factor 0..1 on what each class takes part with in aggregation and breakage [class][lanes],
  /// or null for 1
  /// @param carry          number, liquid and gas [3 n_classes] of the compartment before the first, or null
  /// @param breakage       false: without it
  void rates(const double* state, const double* participation, const double* carry, Inputs inputs, bool breakage,
             double* rates);
  /// out += factor A state, A: the linear map of breakage at the last look_at_particles().
  void add_breakage(double factor, const double* state, double* out);
  /// Solves y - gamma A y = r in place.
  void solve_breakage(double gamma, double* state);

  /// Loss rate per particle by aggregation and breakage at the last rates() [1/s], [class][lanes].
  std::span<const double> loss_rate() const { return loss_rate_; }
  /// Selection rates [1/s], [class][lanes]; empty without breakage.
  std::span<const double> selection_rate() const { return selection_rate_; }
  const AggregationOperator* aggregation() const { return aggregation_ ? &*aggregation_ : nullptr; }

 private:
  void look_up_selection();
  void add_aggregation(const double* state, const double* participation, double* rates);
  void consolidate(const double* state, double* rates) const;
  void add_feed(double* rates) const;
  void add_spray(const double* state, double* rates) const;
  void add_flow(const double* state, const double* carry, double* rates) const;
  double* flows(double* rates, std::size_t entry) const { return rates + (3 * n_ + entry) * lanes_; }
  bool holds(int compartment) const { return compartment >= first_ && compartment < first_ + count_; }

  const ModelTables* tables_;
  const simd::Operations* do_;
  int first_, count_;
  std::size_t n_, lanes_;
  bool by_particles_ = false, wet_ = false;
  double asperity_ = 0.0;
  ParticleTable particles_;
  std::optional<AggregationOperator> aggregation_;
  std::vector<SelectionFunction> selection_;  ///< by lane
  LaneVector selection_rate_, loss_rate_, births_, scratch_, taking_part_, turnover_;
};

}  // namespace granary::pbm
