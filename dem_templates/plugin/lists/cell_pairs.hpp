// Which spheres are near each other: the contents of a neighbour list. Plain numbers: no LIGGGHTS.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace granary::dem {

struct ListedPair {
  int i, j;  ///< i < j
};

/// Finds the pairs through a grid of cells as wide as the widest pair reaches. The spheres are sorted by cell, those of
/// a row of cells one after the other in memory, and each cell is held against itself and the half of its neighbours.
class CellPairs {
 public:
  /// All pairs with |x_i - x_j| <= factor (r_i + r_j) + skin of which i is one of the first `n_own` spheres: a rank's
  /// own, before its ghosts. Rounding may add pairs that are farther by some 1e-7 of the size of the bed; none is
  /// missed. In the order of the cells. What is no number is near nothing.
  ///
  /// places: x y z of each of the n spheres [m]; radii [m]. Valid until the next call.
  const std::vector<ListedPair>& find(const double* places, const double* radii, std::size_t n_own, std::size_t n,
                                      double factor, double skin);

 private:
  void lay_out(const double* places, const double* radii, std::size_t n, double factor, double skin);
  void sort_by_cell(const double* places, const double* radii, std::size_t n, double factor);
  /// Holds the sorted spheres [from, to) of a cell against [first, last).
  void hold_against(std::uint32_t sphere, std::uint32_t first, std::uint32_t last);

  std::array<double, 3> low_{};
  double cell_size_ = 1.0, skin_ = 0.0;
  std::array<int, 3> n_cells_{};      ///< with an empty one before and after the others in each direction
  std::vector<std::uint32_t> first_;  ///< of each cell's spheres; they end where those of the next cell begin
  std::vector<std::uint32_t> cell_;   ///< of each sphere

  // In the order of the cells. Single precision: half as much to read.
  std::vector<float> x_, y_, z_, reach_;  ///< place from low_, factor times the radius [m]
  std::vector<int> number_;

  std::vector<std::uint32_t> near_;  ///< scratch
  std::size_t n_near_ = 0;
  std::vector<ListedPair> pairs_;
};

}  // namespace granary::dem
