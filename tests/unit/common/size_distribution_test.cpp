#include "common/math/size_distribution.hpp"

#include <gtest/gtest.h>

namespace granary {
namespace {

TEST(Quantile, OfOneClassIsItsDiameter) {
  const std::vector<double> d{1e-3}, w{5.0};
  for (const double q : {0.0, 0.1, 0.5, 1.0}) EXPECT_EQ(1e-3, quantile(d, w, q));
}

TEST(Quantile, LiesHalfWayInLogBetweenTwoEqualClasses) {
  const std::vector<double> d{4e-3, 1e-3}, w{1.0, 1.0};
  EXPECT_NEAR(2e-3, quantile(d, w, 0.5), 1e-15);
}

TEST(Quantile, MovesContinuouslyWithTheWeights) {
  const std::vector<double> d{1e-3, 2e-3, 4e-3};
  double last = quantile(d, std::vector<double>{1.0, 1.0, 0.0}, 0.5);
  for (double w = 0.0; w < 3.0; w += 1e-3) {
    const double now = quantile(d, std::vector<double>{1.0, 1.0, w}, 0.5);
    EXPECT_LT(std::abs(now - last), 2e-6);
    last = now;
  }
}

TEST(Quantile, IgnoresEmptyClassesAndIsZeroWithoutWeight) {
  EXPECT_EQ(2e-3, quantile(std::vector<double>{1e-3, 2e-3}, std::vector<double>{0.0, 3.0}, 0.01));
  EXPECT_EQ(0.0, quantile(std::vector<double>{1e-3}, std::vector<double>{0.0}, 0.5));
}

TEST(Sphere, DiameterAndVolumeAreInverse) { EXPECT_NEAR(3e-4, sphere_diameter(sphere_volume(3e-4)), 1e-18); }

}  // namespace
}  // namespace granary
