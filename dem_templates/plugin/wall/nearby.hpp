// The parts of a surface near a sphere's centre, as they were found there.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

namespace granary::dem {

/// A face and how far it is from some place, at least.
struct NearPart {
  std::uint32_t number;
  float distance;  ///< [m]
};

/// Costs only time when it is lost; starts empty.
struct alignas(64) Nearby {
  static constexpr std::size_t kMost = 27, kRow = 4;
  /// So many are held against the radius at once, whether one is near enough or all: which it is can't be foreseen.
  struct Row {
    std::array<float, kRow> distance;  ///< [m]
    std::array<std::uint32_t, kRow> number;
  };

  std::array<float, 3> place{};  ///< of the centre then
  float complete = 0.0f;         ///< everything nearer to that place is listed [m]
  std::uint32_t n = 0;
  alignas(32) std::array<Row, (kMost + 1) / kRow> row{};  ///< the nearest first; after the last, infinitely far ones

  float distance(std::size_t k) const { return row[k / kRow].distance[k % kRow]; }
  void set(std::size_t k, const NearPart& part) {
    row[k / kRow].distance[k % kRow] = part.distance;
    row[k / kRow].number[k % kRow] = part.number;
  }
  NearPart part(std::size_t k) const { return {row[k / kRow].number[k % kRow], distance(k)}; }
  /// They are n.
  void end_after(std::size_t count) {
    n = static_cast<std::uint32_t>(count);
    for (std::size_t k = n; k < (n / kRow + 1) * kRow; ++k) set(k, {0, std::numeric_limits<float>::infinity()});
  }
};

}  // namespace granary::dem
