// Which of the listed pairs touch now. Plain numbers: no LIGGGHTS.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace granary::dem {

/// Of thousands of listed pairs some dozens touch. Two spheres that were `gap` apart when the list was made, and of
/// which none has moved farther than `moved` in a frame that both share, cannot touch before 2 moved = gap: the pairs
/// are kept sorted by their gaps, and only the nearest ones are looked at.
class NearPairs {
 public:
  /// Sphere j is the one with this place among the listed neighbours of i.
  struct Pair {
    std::uint32_t i, j, place;
  };

  /// The list has been made: these are its pairs. widest: of the gaps, about [m].
  void start(std::span<const Pair> pairs, const double* places, const double* radii, double widest);

  std::size_t size() const { return pairs_.size(); }
  /// In an order of its own, until the next start().
  const Pair& pair(std::size_t number) const { return pairs_[number]; }

  /// Numbers of the pairs nearer than their radii, ascending; until the next call. moved: since start(); any larger
  /// number will do [m].
  std::span<const std::uint32_t> touching(const double* places, double moved);

 private:
  static constexpr std::size_t kDrawers = 32;

  double drawer_width_ = 1.0, rounding_ = 0.0;     ///< [m]
  std::array<std::size_t, kDrawers + 1> first_{};  ///< of the pairs in each drawer: by their gaps, in equal steps
  std::vector<Pair> pairs_;
  std::vector<double> touching2_;        ///< of each pair, square of the sum of the radii [m^2]
  std::vector<std::uint8_t> drawer_;     ///< scratch, of each pair
  std::vector<std::uint32_t> touching_;  ///< scratch
};

}  // namespace granary::dem
