#include "dem_templates/plugin/motion/sphere_motion.hpp"

#include "common/every_width.hpp"

// Every sphere comes through here in every step: written so that the compiler can take several at once, and compiled
// for the width of each processor. No product is fused with a sum (CMakeLists.txt), so that all round alike.

namespace granary::dem {
namespace {

constexpr double kInertia = 0.4;  // of a sphere, over m R^2

GRANARY_EVERY_WIDTH void add_over_mass(double* __restrict velocity, const double* __restrict force,
                                       const double* __restrict mass, std::size_t n, double half_step) {
  for (std::size_t i = 0; i < n; ++i) {
    const double factor = half_step / mass[i];
    for (std::size_t d = 0; d < 3; ++d) velocity[3 * i + d] += factor * force[3 * i + d];
  }
}

GRANARY_EVERY_WIDTH void add_over_inertia(double* __restrict spin, const double* __restrict torque,
                                          const double* __restrict mass, const double* __restrict radius, std::size_t n,
                                          double half_step) {
  const double over_inertia = half_step / kInertia;
  for (std::size_t i = 0; i < n; ++i) {
    const double factor = over_inertia / (radius[i] * radius[i] * mass[i]);
    for (std::size_t d = 0; d < 3; ++d) spin[3 * i + d] += factor * torque[3 * i + d];
  }
}

GRANARY_EVERY_WIDTH void add_way(double* __restrict place, const double* __restrict velocity, std::size_t n,
                                 double step) {
  for (std::size_t k = 0; k < 3 * n; ++k) place[k] += step * velocity[k];
}

GRANARY_EVERY_WIDTH void add_weight(double* __restrict force, const double* __restrict mass, std::size_t n, double x,
                                    double y, double z) {
  for (std::size_t i = 0; i < n; ++i) {
    force[3 * i] += mass[i] * x;
    force[3 * i + 1] += mass[i] * y;
    force[3 * i + 2] += mass[i] * z;
  }
}

}  // namespace

void kick(const SphereArrays& s, std::size_t n, double half_step) {
  add_over_mass(s.velocity, s.force, s.mass, n, half_step);
  add_over_inertia(s.spin, s.torque, s.mass, s.radius, n, half_step);
}

void kick_and_move(const SphereArrays& s, std::size_t n, double half_step, double step) {
  kick(s, n, half_step);
  add_way(s.place, s.velocity, n, step);
}

void weigh(const SphereArrays& s, std::size_t n, const std::array<double, 3>& g) {
  add_weight(s.force, s.mass, n, g[0], g[1], g[2]);
}

}  // namespace granary::dem
