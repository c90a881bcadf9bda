// A plain solver in the style of the published codes, to measure ours against: a loop over all ordered pairs of
// classes, a search for the target cell in each pair, explicit Euler with a limit on what a step may take away.
// It has the physics right (unlike some of them), so that its errors compare; it is built with the same flags as ours.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pbm_solver/model/class_grid.hpp"
#include "pbm_solver/time/snapshot.hpp"

namespace granary::pbm::bench {

/// How the reference finds the cell of a sum of volumes: the published codes try one cell after the other (all of them,
/// where this one ends at the right one); bisection is what a careful author would write.
enum class CellSearch { scan, bisection };

/// Totals of the classes of every compartment, or their rates of change; shape (X, n_classes) each.
struct ReferenceState {
  std::vector<double> number, liquid, gas;
};

/// Aggregation alone, in compartments that do not exchange anything. For every ordered pair (k, m) of classes, each
/// unordered pair so being met twice:
///
///   birth += 1/2 beta_km (F_k F_m, ... (s1_k + s1_m), ... (s2_k + s2_m), L_k F_m + F_k L_m, G_k F_m + F_k G_m)
///   death_k += beta_km F_m
///
/// then the cell average on the same cells as ours. beta_km = scale_x table[class_k][class_m] [1/s], class by dry solid
/// volume. O(X n_classes^2), with a search for the row and one for the column in each pair.
class ReferenceSolver {
 public:
  /// The case's aggregation must be a constant kernel, or the exact table of DEM classes, with constant efficiency
  /// (asserted); everything else in the case is left out.
  explicit ReferenceSolver(const PbmCase& pbm_case, CellSearch search = CellSearch::scan);

  std::size_t compartments() const { return scale_.size(); }
  const ClassGrid& grid() const { return grid_; }

  /// d(state)/dt of all compartments, or of one of them (the others are left as they are).
  void rates(const ReferenceState& state, ReferenceState& rates);
  void rates_of_compartment(std::size_t x, const ReferenceState& state, ReferenceState& rates);

 private:
  struct Cell {
    double number, solid_1, solid_2, liquid, gas;
  };
  template <class Search>
  void collect_pairs(std::size_t x, const ReferenceState& state, ReferenceState& rates, Search cell_of);
  void share_cells(std::size_t x, ReferenceState& rates) const;

  CellSearch search_;
  ClassGrid grid_;
  std::size_t rows_, columns_;
  std::vector<double> row_edges_, column_edges_;  ///< upper edges of the cells [m^3]
  std::vector<double> scale_;                     ///< by compartment [1/m^3]
  std::vector<std::size_t> class_of_;             ///< kernel class of each class of the grid
  std::vector<double> table_;                     ///< kernel by class and class [m^3/s]
  std::size_t n_kernel_classes_;
  std::vector<Cell> cells_;  ///< births; one more row and column for what lands above the grid
};

ReferenceState reference_state(const Snapshot& snapshot);

struct EulerRun {
  std::int64_t steps = 0;  ///< one right-hand side each
  double cpu = 0.0;        ///< of this thread [s]
  bool finished = false;   ///< false: `most_cpu` was used up first
};

/// Explicit Euler as published: dt is doubled while max(-dF/dt / F) dt < limit over all contents F of all classes, and
/// halved while it is above; here without their floor and ceiling in seconds, which belong to their process. The last
/// step ends at `end`.
/// @param limit  share of a class that a step may take away: 0.1 in the published codes
EulerRun run_euler(ReferenceSolver& solver, ReferenceState& state, double end, double limit, double most_cpu);

}  // namespace granary::pbm::bench
