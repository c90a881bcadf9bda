// The normal speed at first touch, found from a moment after it.
#include "dem_templates/plugin/tally/touch_speed.hpp"

#include <gtest/gtest.h>

#include <random>

namespace granary::dem {
namespace {

TEST(TouchSpeed, IsThatOfTheFlightWhereverOnItsLineOneLooks) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int flights = 0;
  while (flights < 200) {
    const double R = 1.0;
    double d[3] = {3.0, uniform(random), uniform(random)};
    const double v[3] = {-2.0, uniform(random), uniform(random)};
    const double dt = 1e-6;
    int steps = 0;
    const auto fly = [&] {
      for (int k = 0; k < 3; ++k) d[k] += v[k] * dt;
    };
    const auto distance = [&] { return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]); };
    // straight to just before the touch, then step by step over it
    const double a = v[0] * v[0] + v[1] * v[1] + v[2] * v[2], b = d[0] * v[0] + d[1] * v[1] + d[2] * v[2];
    const double c = distance() * distance() - R * R, root = b * b - a * c;
    if (root <= 1e-3) continue;  // it misses, or nearly so
    const double touch = (-b - std::sqrt(root)) / a;
    for (int k = 0; k < 3; ++k) d[k] += v[k] * (touch - 2 * dt);
    while (distance() > R && ++steps < 10) fly();
    const double at_touch = -(d[0] * v[0] + d[1] * v[1] + d[2] * v[2]) / distance();
    for (int later = 0; later < 5; ++later, fly()) EXPECT_NEAR(touch_speed(d, v, R), at_touch, 1e-4);
    ++flights;
  }
}

TEST(TouchSpeed, IsTheWholeSpeedHeadOnAndNothingAtRest) {
  const double d[3] = {0.9, 0, 0}, head_on[3] = {-3, 0, 0}, rest[3] = {0, 0, 0};
  EXPECT_DOUBLE_EQ(touch_speed(d, head_on, 1.0), 3.0);
  EXPECT_DOUBLE_EQ(touch_speed(d, rest, 1.0), 0.0);
}

}  // namespace
}  // namespace granary::dem
