// The time step that the bonds bear.
#pragma once

#include <algorithm>
#include <cmath>

#include "dem_templates/plugin/bond/bond_law.hpp"

namespace granary::dem {

/// What the bonds of one particle add up to: an upper bound of the stiffness against displacements and rotations.
///
/// The energy of a bond is at most that of its two ends alone, with 2 K_n and 7 K_s against a displacement, 2 K_bend
/// and 2 K_twist and 7/2.5 K_s a^2 against a rotation (a sum of four terms, squared, is at most the sum of their
/// squares over shares that add up to one: 1/7 for each displacement, 2.5/7 for each rotation at 2/5 m r^2). So the
/// highest frequency of the whole is at most the largest of any particle by itself: rigorous. It is
/// exact for a pair, 1.5 times the highest frequency for a packing: room for the contacts, which may be stiffer still.
struct BondStiffness {
  static constexpr std::size_t kNumbers = 12;  ///< two symmetric matrices: xx yy zz xy xz yz

  /// Adds a bond to what an end of it has; arm: from the end's centre to the section [m].
  static void add(const BondSection& s, const Vector3& normal, double arm, double* numbers) {
    add(2.0 * s.normal, 7.0 * s.shear, normal, numbers);
    add(2.0 * s.twist, 2.8 * s.shear * arm * arm + 2.0 * s.bend, normal, numbers + 6);
  }
  /// The square of the highest frequency [1/s^2].
  static double frequency2(const double* numbers, const BondEnd& end) {
    return std::max(largest(numbers) / end.mass, largest(numbers + 6) / (0.4 * end.mass * end.radius * end.radius));
  }

 private:
  static void add(double along, double across, const Vector3& n, double* m) {
    const double more = along - across;
    for (std::size_t d = 0; d < 3; ++d) m[d] += across + more * n[d] * n[d];
    m[3] += more * n[0] * n[1];
    m[4] += more * n[0] * n[2];
    m[5] += more * n[1] * n[2];
  }
  // No eigenvalue is above the largest sum of a row, nor above the root of the sum of squares.
  static double largest(const double* m) {
    const double xy = std::abs(m[3]), xz = std::abs(m[4]), yz = std::abs(m[5]);
    const double rows = std::max({m[0] + xy + xz, m[1] + xy + yz, m[2] + xz + yz});
    return std::min(rows, std::sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2] + 2.0 * (xy * xy + xz * xz + yz * yz)));
  }
};

/// The longest stable step of an oscillator whose dashpot goes by the velocity half a step before [s]:
///   2/w (sqrt(1 + d^2) - d),  d the damping over the critical one.
inline double longest_bond_step(double frequency2, double damping) {
  return 2.0 / std::sqrt(frequency2) * (std::sqrt(1.0 + damping * damping) - damping);
}

}  // namespace granary::dem
