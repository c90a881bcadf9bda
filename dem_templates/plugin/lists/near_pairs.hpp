// Which of the listed pairs may touch now. Plain numbers: no LIGGGHTS.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dem_templates/plugin/lists/cell_pairs.hpp"

namespace granary::dem {

/// Of thousands of listed pairs some dozens touch. Two spheres that were `gap` apart when the list was made, and of
/// which none has moved farther than `moved` in a frame that both share, cannot touch before 2 moved = gap: the pairs
/// are kept sorted by their gaps, and only the nearest ones are looked at.
class NearPairs {
 public:
  /// The list has been made: these are its pairs. widest: of the gaps, about [m]; n: number of spheres.
  void start(std::span<const ListedPair> pairs, const double* places, const double* radii, std::size_t n,
             double widest);

  /// Numbers i, ascending, of those with a pair (i, j) nearer than its radii, or nearly so. moved: since start(); any
  /// larger number will do [m].
  std::vector<int>& touching(const double* places, double moved);

 private:
  static constexpr std::size_t kDrawers = 32;

  double drawer_width_ = 1.0, rounding_ = 0.0;     ///< [m]
  std::array<std::size_t, kDrawers + 1> first_{};  ///< of the pairs in each drawer: by their gaps, in equal steps
  struct Pair {
    std::uint32_t i, j;
    double touching2;  ///< square of the sum of the radii [m^2]
  };
  std::vector<Pair> pairs_;
  std::vector<std::uint8_t> drawer_;       ///< scratch, of each pair
  std::vector<std::uint8_t> is_touching_;  ///< of each sphere; filled up to a multiple of 8
  std::vector<int> touching_;
};

}  // namespace granary::dem
