// A step of free spheres, many at once. Plain numbers: no LIGGGHTS.
#pragma once

#include <array>
#include <cstddef>

namespace granary::dem {

/// x y z of each sphere, one after the other.
struct SphereArrays {
  double *place, *velocity, *spin;  ///< [m], [m/s], [rad/s]
  double *force, *torque;           ///< [N], [N m]
  const double *mass, *radius;      ///< one number a sphere [kg], [m]
};

/// Half a step of velocity Verlet, half_step = dt/2:
///
///   v += half_step F / m        w += half_step T / (2/5 m R^2)
///
/// The numbers are those of LIGGGHTS' nve/sphere to the last bit, on every processor.
void kick(const SphereArrays& spheres, std::size_t n, double half_step);

/// The same, and then a whole step on: x += step v.
void kick_and_move(const SphereArrays& spheres, std::size_t n, double half_step, double step);

/// F += m g, g in [m/s^2].
void weigh(const SphereArrays& spheres, std::size_t n, const std::array<double, 3>& g);

}  // namespace granary::dem
