// The parts of a surface near a sphere's centre, as they were found there.
#pragma once

#include <array>
#include <cstdint>

namespace granary::dem {

/// A face and how far it is from some place, at least.
struct NearPart {
  std::uint32_t number;
  float distance;  ///< [m]
};

/// Costs only time when it is lost; starts empty.
struct alignas(64) Nearby {
  static constexpr std::size_t kMost = 29;

  std::array<float, 3> place{};  ///< of the centre then
  float complete = 0.0f;         ///< everything nearer to that place is listed [m]
  std::uint32_t n = 0;
  std::array<NearPart, kMost> part{};  ///< the nearest first
};

}  // namespace granary::dem
