// Vectors and rotations for the walls.
#pragma once

#include <cmath>

#include "dem_templates/plugin/resize/vector3.hpp"

namespace granary::dem {

/// Of three numbers in a row.
inline Vector3 vector_of(const double* v) { return {v[0], v[1], v[2]}; }

/// A rotation of space: rows of its matrix, from the turned body's frame to the laboratory's.
struct Turn {
  Vector3 row[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  /// By an angle about a unit axis, right-handed [rad].
  static Turn about(const Vector3& axis, double angle) {
    const double c = std::cos(angle), s = std::sin(angle), d = 1.0 - c;
    const auto& [x, y, z] = axis;
    return {{{c + d * x * x, d * x * y - s * z, d * x * z + s * y},
             {d * x * y + s * z, c + d * y * y, d * y * z - s * x},
             {d * x * z - s * y, d * y * z + s * x, c + d * z * z}}};
  }
  Vector3 to_lab(const Vector3& v) const { return {dot(row[0], v), dot(row[1], v), dot(row[2], v)}; }
  Vector3 to_body(const Vector3& v) const { return v[0] * row[0] + v[1] * row[1] + v[2] * row[2]; }
};

/// How a body moves: about a fixed axis, at a steady rate.
struct Rotation {
  Vector3 origin{};       ///< a point of the axis [m]
  Vector3 axis{0, 0, 1};  ///< unit vector
  double rate = 0.0;      ///< right-handed about the axis [rad/s]; 0: it stands still
};

}  // namespace granary::dem
