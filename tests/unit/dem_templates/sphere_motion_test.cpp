// Spheres moved many at once, against the formula sphere by sphere.
#include "dem_templates/plugin/motion/sphere_motion.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace granary::dem {
namespace {

struct Cloud {
  std::vector<double> place, velocity, spin, force, torque, mass, radius;

  explicit Cloud(std::size_t n) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> way(-1.0, 1.0), size(0.5e-3, 2e-3);
    for (std::vector<double>* of : {&place, &velocity, &spin, &force, &torque})
      for (std::size_t k = 0; k < 3 * n; ++k) of->push_back(way(random));
    for (std::size_t i = 0; i < n; ++i) {
      radius.push_back(size(random));
      mass.push_back(4e3 * radius[i] * radius[i] * radius[i]);
    }
  }
  SphereArrays arrays() {
    return {place.data(), velocity.data(), spin.data(), force.data(), torque.data(), mass.data(), radius.data()};
  }
};

TEST(SphereMotion, IsThatOfEachSphereToTheLastBit) {
  constexpr double kStep = 5e-6;
  for (const std::size_t n : {0u, 1u, 7u, 100u}) {
    Cloud fast(n), slow(n);
    weigh(fast.arrays(), n, {0.1, -9.80665, 0.2});
    kick_and_move(fast.arrays(), n, 0.5 * kStep, kStep);
    kick(fast.arrays(), n, 0.5 * kStep);

    for (std::size_t i = 0; i < n; ++i) {
      const double g[3] = {0.1, -9.80665, 0.2};
      const double by_mass = 0.5 * kStep / slow.mass[i];
      const double by_inertia = 0.5 * kStep / 0.4 / (slow.radius[i] * slow.radius[i] * slow.mass[i]);
      for (std::size_t d = 0; d < 3; ++d) {
        const std::size_t k = 3 * i + d;
        // volatile: each operation rounds by itself.
        const auto plus = [](double a, double b, double c) {
          const volatile double product = b * c;
          return a + product;
        };
        slow.force[k] = plus(slow.force[k], slow.mass[i], g[d]);
        slow.velocity[k] = plus(slow.velocity[k], by_mass, slow.force[k]);
        slow.spin[k] = plus(slow.spin[k], by_inertia, slow.torque[k]);
        slow.place[k] = plus(slow.place[k], kStep, slow.velocity[k]);
        slow.velocity[k] = plus(slow.velocity[k], by_mass, slow.force[k]);
        slow.spin[k] = plus(slow.spin[k], by_inertia, slow.torque[k]);
      }
    }
    EXPECT_EQ(fast.place, slow.place);
    EXPECT_EQ(fast.velocity, slow.velocity);
    EXPECT_EQ(fast.spin, slow.spin);
    EXPECT_EQ(fast.force, slow.force);
    EXPECT_EQ(fast.torque, slow.torque);
  }
}

}  // namespace
}  // namespace granary::dem
