// What the tally remembers of a particle from one look to the next. Follows it when the particles are renumbered,
// deleted or sent to another rank.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace granary::dem {

constexpr std::size_t kMostBodies = 52;  ///< bits that a double carries exactly

struct Memory {
  double axial = std::numeric_limits<double>::quiet_NaN();  ///< place along the axis when last surveyed [m]

  // For bodies that must be looked at:
  bool known = false;                ///< false: it was not there at the last look
  std::array<double, 3> velocity{};  ///< at the last look [m/s]
  std::uint64_t bodies = 0;          ///< bit b: it touched body b at the last look

  static constexpr std::size_t kDoubles = 6;
  void pack(double* buffer) const {
    buffer[0] = axial;
    buffer[1] = known ? 1.0 : 0.0;
    std::copy(velocity.begin(), velocity.end(), buffer + 2);
    buffer[5] = static_cast<double>(bodies);
  }
  static Memory unpack(const double* buffer) {
    return {buffer[0], buffer[1] != 0.0, {buffer[2], buffer[3], buffer[4]}, static_cast<std::uint64_t>(buffer[5])};
  }
};

}  // namespace granary::dem
