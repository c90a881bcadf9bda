// The classes of a population: pivots on a tensor grid of the two solid volumes, the cells around them, and where the
// sum of two pivots falls. Computed once; shared by all compartments.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pbm_solver/case/pbm_case.hpp"

namespace granary::pbm {

/// The two neighbouring pivots a mean lies between, and what part goes to each (they sum to 1).
struct PivotShare {
  int lower = 0;  ///< index of the lower pivot; the upper one is lower + 1
  double to_lower = 1.0;
  double to_upper = 0.0;
};

/// Indices first .. last; none if first > last.
struct PartnerRange {
  int first = 1;
  int last = 0;
  bool empty() const { return first > last; }
};

/// The pivots x_i = smallest q^i of one solid [m^3], each in the middle of its cell:
///   cell i = [e_i, e_{i+1}),  e_i = 2 x_i / (1 + q),   but cell 0 begins at 0 and the last one ends with x_{n-1}.
/// What lies above the last pivot is outside. A solid that is absent is one class at 0.
class SolidAxis {
 public:
  SolidAxis(int bins, double smallest, double ratio);

  int size() const { return static_cast<int>(pivot_.size()); }
  std::span<const double> pivots() const { return pivot_; }
  double pivot(int i) const { return pivot_[static_cast<std::size_t>(i)]; }
  bool absent() const { return pivot_.front() == 0.0; }
  /// Cell that holds the volume v >= 0; size() if it lies above the last pivot. A v within round-off of an edge counts
  /// as on it.
  int cell(double v) const;
  /// Lower edge of cell i; the upper edge of cell i is lower_edge(i + 1), and lower_edge(size()) is the last pivot.
  double lower_edge(int i) const { return edge_[static_cast<std::size_t>(i)]; }
  /// cell(pivot(i) + pivot(k)), from a table.
  int sum_cell(int i, int k) const { return sum_cell_[static_cast<std::size_t>(i * size() + k)]; }
  const int* sum_cells(int i) const { return &sum_cell_[static_cast<std::size_t>(i * size())]; }
  /// The i' <= i whose sum with i falls into cell i + offset lie side by side on any rising grid.
  PartnerRange partners(int i, int offset) const { return partners_[static_cast<std::size_t>(offset * size() + i)]; }
  /// partners() has offsets 0 .. offsets() - 1.
  int offsets() const { return offsets_; }
  /// Largest k such that pivot(i) + pivot(k) is in the grid; -1: none.
  int highest_partner(int i) const { return highest_partner_[static_cast<std::size_t>(i)]; }
  /// How a mean within `cell` is shared between its pivot and the neighbour on the mean's side:
  /// to_lower + to_upper = 1 and to_lower x_lower + to_upper x_upper = mean. Below the first pivot all goes to it.
  PivotShare share(int cell, double mean) const;

 private:
  void list_partners();

  std::vector<double> pivot_;
  std::vector<double> edge_;
  std::vector<int> sum_cell_;
  std::vector<PartnerRange> partners_;  ///< shape (offsets_, size)
  std::vector<int> highest_partner_;
  int offsets_ = 1;
};

/// Class k = i * size(axis 1) + j holds particles with pivot(i) of solid 1 and pivot(j) of solid 2.
class ClassGrid {
 public:
  explicit ClassGrid(const Grid& grid);

  const SolidAxis& axis(int solid) const { return axes_[static_cast<std::size_t>(solid)]; }
  std::size_t size() const { return solid_.size(); }
  std::size_t index(int i, int j) const { return static_cast<std::size_t>(i * axes_[1].size() + j); }
  /// Volume of solid 1, of solid 2, of both, in one particle of each class [m^3], shape (size)
  std::span<const double> solid_1() const { return solid_1_; }
  std::span<const double> solid_2() const { return solid_2_; }
  std::span<const double> solid() const { return solid_; }

 private:
  std::array<SolidAxis, 2> axes_;
  std::vector<double> solid_1_, solid_2_, solid_;
};

}  // namespace granary::pbm
