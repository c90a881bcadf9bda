// Intervals against models whose posterior is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimation/trust/posterior.hpp"
#include "estimation/trust/uncertainty.hpp"

namespace granary::estimation {
namespace {

using testing::DoubleNear;

std::vector<Residuals> around(const Point& centre, double step, Residuals (*model)(const Point&)) {
  std::vector<Residuals> all;
  for (const Point& p : difference_points(centre, step)) all.push_back(model(p));
  return all;
}

/// r = A (p - 1/2), A = ((30, 10), (10, 40)).
Residuals linear(const Point& p) {
  const double x = p[0] - 0.5, y = p[1] - 0.5;
  return {30.0 * x + 10.0 * y, 10.0 * x + 40.0 * y};
}

TEST(Uncertainty, IsTheInverseOfTheInformationForALinearModel) {
  const auto u = uncertainty_of({0.5, 0.5}, linear({0.5, 0.5}), around({0.5, 0.5}, 0.01, linear), 0.01);
  ASSERT_TRUE(u.has_value());
  // A^T A + 12 = ((1012, 700), (700, 1712)); its determinant 1012 x 1712 - 700^2 = 1 242 544.
  EXPECT_NEAR(u->covariance[0][0], 1712.0 / 1242544.0, 1e-12);
  EXPECT_NEAR(u->covariance[1][1], 1012.0 / 1242544.0, 1e-12);
  EXPECT_NEAR(u->correlation[0][1], -700.0 / std::sqrt(1012.0 * 1712.0), 1e-9);
  EXPECT_NEAR(u->high[0] - u->low[0], 2.0 * 1.959964 * std::sqrt(1712.0 / 1242544.0), 1e-9);
  EXPECT_TRUE(u->unidentified.empty());
  EXPECT_FALSE(u->at_bound[0]);
}

/// The data see only the product of the first two parameters (on log scales: their sum).
Residuals product(const Point& p) { return {50.0 * (p[0] + p[1] - 0.9), 40.0 * (p[2] - 0.3)}; }

TEST(Uncertainty, NamesTheCombinationThatTheDataCannotTell) {
  const Point best{0.4, 0.5, 0.3};
  const auto u = uncertainty_of(best, product(best), around(best, 0.01, product), 0.01);
  ASSERT_TRUE(u.has_value());
  ASSERT_EQ(u->unidentified.size(), 1u);
  const std::vector<double>& v = u->unidentified[0].direction;
  EXPECT_NEAR(std::abs(v[0] - v[1]), std::sqrt(2.0), 1e-6);  // up with one is down with the other
  EXPECT_NEAR(v[2], 0.0, 1e-6);
  EXPECT_NEAR(u->correlation[0][1], -1.0, 0.05);
  EXPECT_TRUE(u->at_bound[0]);
  EXPECT_LT(u->high[2] - u->low[2], 0.11);
}

TEST(Uncertainty, WidensWhereTheMisfitIsLargerThanTheErrorsSay) {
  Residuals misfit = linear({0.5, 0.5});
  std::vector<Residuals> near = around({0.5, 0.5}, 0.01, linear);
  const auto add = [](Residuals r) {
    for (int k = 0; k < 10; ++k) r.push_back(3.0);
    return r;
  };
  for (Residuals& r : near) r = add(r);
  const auto u = uncertainty_of({0.5, 0.5}, add(misfit), near, 0.01);
  ASSERT_TRUE(u.has_value());
  EXPECT_NEAR(u->chi_square_per_datum, 9.0, 1e-9);
  EXPECT_GT(u->deviation[0], 2.5 * std::sqrt(1712.0 / 1242544.0));
}

TEST(Uncertainty, GoesOnWithOneSideWhereTheOtherFailedAndSaysSoWhereBothDid) {
  std::vector<Residuals> near = around({0.5, 0.5}, 0.01, linear);
  near[0].clear();
  const auto u = uncertainty_of({0.5, 0.5}, linear({0.5, 0.5}), near, 0.01);
  ASSERT_TRUE(u.has_value());
  EXPECT_NEAR(u->covariance[0][0], 1712.0 / 1242544.0, 1e-12);
  near[1].clear();
  const auto none = uncertainty_of({0.5, 0.5}, linear({0.5, 0.5}), near, 0.01);
  ASSERT_FALSE(none.has_value());
  EXPECT_THAT(none.error().message, testing::HasSubstr("parameter 0"));
}

TEST(Uncertainty, StepsToTheInsideAtABound) {
  EXPECT_THAT(difference_points({0.0}, 0.1), testing::ElementsAre(Point{0.0}, Point{0.1}));
  EXPECT_THAT(difference_points({1.0}, 0.1), testing::ElementsAre(Point{0.9}, Point{1.0}));
}

Posterior sampled(const Point& centre, Residuals (*model)(const Point&), double step, int most) {
  const auto u = uncertainty_of(centre, model(centre), around(centre, step, model), step);
  Posterior posterior(centre, u->covariance, 11);
  for (int k = 0; k < most; ++k) {
    const Point p = posterior.ask();
    posterior.tell(p, k % 17 == 3 ? std::nullopt : std::optional(model(p)));
  }
  return posterior;
}

TEST(Posterior, OfALinearModelIsItsGaussian) {
  const Posterior posterior = sampled({0.5, 0.5}, linear, 0.01, 4000);
  EXPECT_GT(posterior.effective_samples(), 1000.0);
  // A^T A = ((1000, 700), (700, 1700)), determinant 1 210 000: variances 1700 and 1000 over it.
  const double half_0 = 1.96 * std::sqrt(1700.0 / 1210000.0), half_1 = 1.96 * std::sqrt(1000.0 / 1210000.0);
  const auto a = posterior.interval(0), b = posterior.interval(1);
  ASSERT_TRUE(a && b);
  EXPECT_THAT(a->low, DoubleNear(0.5 - half_0, 0.1 * half_0));
  EXPECT_THAT(a->high, DoubleNear(0.5 + half_0, 0.1 * half_0));
  EXPECT_THAT(b->high, DoubleNear(0.5 + half_1, 0.1 * half_1));
}

/// A bent valley: p1 follows 2 (p0 - 1/2)^2; p0 itself within 0.2 or so. A parabola at its bottom knows nothing of
/// that.
Residuals bent(const Point& p) {
  return {(p[0] - 0.5) / 0.15, (p[1] - 0.2 - 2.0 * (p[0] - 0.5) * (p[0] - 0.5)) / 0.01};
}

TEST(Posterior, FollowsABentValleyThatAParabolaCuts) {
  const Point best{0.5, 0.2};
  const auto u = uncertainty_of(best, bent(best), around(best, 0.005, bent), 0.005);
  ASSERT_TRUE(u.has_value());
  const Posterior posterior = sampled(best, bent, 0.005, 6000);
  const auto interval = posterior.interval(1);
  ASSERT_TRUE(interval.has_value());
  // p1 - 0.2 = 2 (0.15 z)^2 + 0.01 e: its 97.5 % quantile is about 2 (0.15 x 2.24)^2 = 0.226.
  EXPECT_LT(u->high[1], 0.23);
  EXPECT_GT(interval->high, 0.2 + 0.226 - 0.05);
  EXPECT_LT(interval->high, 0.2 + 0.226 + 0.1);  // further out by the standard error of the tail's share
  EXPECT_GT(interval->low, 0.17);
}

}  // namespace
}  // namespace granary::estimation
