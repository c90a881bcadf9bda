// The normal speed at which two bodies in free flight touch.
#pragma once

#include <algorithm>
#include <cmath>

namespace granary::dem {

/// a . b
inline double dot3(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Two spheres overlap now; before they touched they flew with a constant relative velocity v. On that line
///
///   (d . v)^2 - |v|^2 (|d|^2 - R^2)
///
/// is the same at every moment, and where the distance is R it is (R v_n)^2. So the normal speed at first touch is
/// known from any place on the line, also from the present one, a little into the contact.
///
/// @param d  from one centre to the other, now [m]
/// @param v  relative velocity before the contact force acted [m/s]
/// @param R  sum of the radii [m], R >= |d|
/// @return   v_n [m/s], >= 0
/// Source: derived here; checked against flights worked out step by step in touch_speed_test.cpp.
inline double touch_speed(const double* d, const double* v, double R) {
  const double dv = dot3(d, v), v2 = dot3(v, v), d2 = dot3(d, d);
  return std::sqrt(std::max(0.0, dv * dv + v2 * (R * R - d2))) / R;
}

}  // namespace granary::dem
