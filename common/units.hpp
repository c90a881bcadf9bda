// Quantities with units, as people write them, to SI. One home for physical constants.
#pragma once

#include <string>
#include <string_view>

#include "common/result.hpp"

namespace granary {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kGravity = 9.80665;  ///< standard gravity [m/s^2], CGPM 1901

/// "2000 rpm" to "rad/s" -> 209.44. The text is a number and a unit that UDUNITS-2 knows (and "rpm").
/// Errors (message without place): no number, no unit, unknown unit, another dimension than `si_unit`.
Result<double> to_si(std::string_view text, const std::string& si_unit);

}  // namespace granary
