#include "common/math/size_distribution.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace granary {
namespace {

const double kWidth = std::log(2.0);

TEST(Quantile, OfOneClassRunsOverItsWidth) {
  const std::vector<double> d{1e-3}, w{5.0};
  EXPECT_NEAR(1e-3, quantile(d, w, 0.5, kWidth), 1e-15);
  EXPECT_NEAR(1e-3 / std::sqrt(2.0), quantile(d, w, 0.0, kWidth), 1e-15);
  EXPECT_NEAR(1e-3 * std::sqrt(2.0), quantile(d, w, 1.0, kWidth), 1e-15);
}

TEST(Quantile, LiesHalfWayInLogBetweenTwoEqualClasses) {
  const std::vector<double> d{4e-3, 1e-3}, w{1.0, 1.0};
  EXPECT_NEAR(2e-3, quantile(d, w, 0.5, std::log(4.0)), 1e-15);
}

TEST(Quantile, MovesContinuouslyWithTheWeights) {
  const std::vector<double> d{1e-3, 2e-3, 4e-3};
  double last = quantile(d, std::vector<double>{1.0, 1.0, 0.0}, 0.5, kWidth);
  for (double w = 0.0; w < 3.0; w += 1e-3) {
    const double now = quantile(d, std::vector<double>{1.0, 1.0, w}, 0.5, kWidth);
    EXPECT_LT(std::abs(now - last), 2e-6);
    last = now;
  }
}

TEST(Quantile, DoesNotJumpWhereAThinClassPassesAThickOne) {
  double last = 0.0;
  for (double thin = 1.9e-3; thin < 2.1e-3; thin += 1e-6) {
    const double now =
        quantile(std::vector<double>{1e-3, 2e-3, thin, 4e-3}, std::vector<double>{1.0, 2.0, 0.01, 1.0}, 0.5, kWidth);
    if (last > 0.0) {
      EXPECT_LT(std::abs(now - last), 1e-8);
    }
    last = now;
  }
}

TEST(Quantile, IgnoresEmptyClassesAndIsZeroWithoutWeight) {
  const double only = quantile(std::vector<double>{2e-3}, std::vector<double>{3.0}, 0.01, kWidth);
  EXPECT_EQ(only, quantile(std::vector<double>{1e-3, 2e-3}, std::vector<double>{0.0, 3.0}, 0.01, kWidth));
  EXPECT_EQ(0.0, quantile(std::vector<double>{1e-3}, std::vector<double>{0.0}, 0.5, kWidth));
}

TEST(LogWidth, IsThatOfTheFinestAxis) {
  EXPECT_NEAR(std::log(2.0) / 3.0,
              log_width_of_pivots(std::vector<double>{1.0, 3.0, 9.0}, std::vector<double>{1.0, 2.0}), 1e-15);
  EXPECT_NEAR(std::log(3.0) / 3.0, log_width_of_pivots(std::vector<double>{1.0, 3.0}, std::vector<double>{0.0}), 1e-15);
}

TEST(Sphere, DiameterAndVolumeAreInverse) { EXPECT_NEAR(3e-4, sphere_diameter(sphere_volume(3e-4)), 1e-18); }

}  // namespace
}  // namespace granary
