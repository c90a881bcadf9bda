// The sum of all mechanisms in one compartment: dF/dt, dL/dt, dG/dt and what flows in and out. No ranks, no files, no
// time.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/active_classes.hpp"
#include "pbm_solver/model/aggregation.hpp"
#include "pbm_solver/model/cell_average.hpp"
#include "pbm_solver/model/daughter_distribution.hpp"
#include "pbm_solver/model/selection_function.hpp"

namespace granary::pbm {

/// What came into the whole row and left it through one compartment since the start: the book-keeping of conservation.
/// [m^3]; for each of solid 1, solid 2, liquid, gas.
namespace ledger {
enum : std::size_t {
  kStart = 0,            ///< held at the very start
  kIn = 4,               ///< fed and sprayed
  kOut = 8,              ///< left at the end of the row
  kOversize = 12,        ///< left above the grid's last pivots
  kConsolidated = 16,    ///< gas squeezed out
  kOversizeNumber = 17,  ///< particles above the grid [-]
  kSize = 18
};
}  // namespace ledger

/// Volume of solid 1, solid 2, liquid and gas in one compartment [m^3].
std::array<double, 4> holdup(const ClassGrid& grid, Fields state);

/// Which inputs are on during a step: the steps end at every switch.
struct Inputs {
  bool feed = false;
  bool spray = false;
};
Inputs inputs_at(const PbmCase& pbm_case, double time);

/// What all compartments share. Absent mechanisms are absent here too.
struct ModelTables {
  explicit ModelTables(const PbmCase& pbm_case);
  PbmCase pbm_case;
  ClassGrid grid;
  std::optional<DaughterDistribution> daughters;
  std::vector<double> ln_dem_diameter;  ///< empty: nothing looks at DEM classes
};

/// Rates of one compartment in three steps, so that threads can share the pairs of several compartments:
/// prepare(), run_part() for every part (at the same time if wanted), finish().
class Compartment {
 public:
  Compartment(const ModelTables& tables, int index);

  /// Number of parts of run_part(): 0 without aggregation.
  int parts() const { return aggregation_ ? Aggregation2d::kParts : 0; }
  /// @param participation  see ActiveClasses::assign; empty: everything takes part
  void prepare(Fields state, std::span<const double> participation);
  void run_part(int part) { aggregation_->run_part(part, *kernel_, classes_); }
  /// @param upstream  the state of the compartment before it; empty spans for the first
  /// @param rates     overwritten, shape (n_classes) each
  /// @param flows     rates of change of the ledger, overwritten, shape (ledger::kSize)
  void finish(Fields state, Fields upstream, Inputs inputs, FieldRates rates, std::span<double> flows);
  /// Loss rate per particle by aggregation and breakage at the last finish() [1/s], shape (n_classes)
  std::span<const double> loss_rate() const { return loss_rate_; }

 private:
  void add_kinetics(FieldRates rates, std::span<double> flows);
  void add_breakage();
  void consolidate(Fields state, FieldRates rates, std::span<double> flows) const;
  void add_feed(FieldRates rates, std::span<double> flows) const;
  void add_spray(Fields state, FieldRates rates, std::span<double> flows) const;
  void add_flow(Fields state, Fields upstream, FieldRates rates, std::span<double> flows) const;

  const ModelTables* tables_;
  int index_;
  ActiveClasses classes_;
  std::optional<AggregationKernel> kernel_;
  std::optional<Aggregation2d> aggregation_;
  std::optional<SelectionFunction> selection_;
  BirthGrid births_;
  Broken broken_;
  std::vector<double> death_;      ///< per particle, by active class [1/s]
  std::vector<double> loss_rate_;  ///< by class [1/s]
};

}  // namespace granary::pbm
