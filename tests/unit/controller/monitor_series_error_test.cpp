// The error of a mean, held against the scatter of the means of many made series.
#include "controller/monitor/series_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace granary::monitor {
namespace {

/// Variance 1, correlation rho^k after k values.
std::vector<double> series(std::mt19937& random, std::size_t n, double rho) {
  std::normal_distribution<double> normal;
  std::vector<double> values{normal(random)};
  while (values.size() < n) values.push_back(rho * values.back() + std::sqrt(1.0 - rho * rho) * normal(random));
  return values;
}

/// Root mean square of the error that is told, over that of the mean itself, whose true value is 0.
double told_over_true(std::size_t n, double rho) {
  std::mt19937 random(11);
  double told = 0.0, truth = 0.0;
  for (int k = 0; k < 4000; ++k) {
    const std::vector<double> values = series(random, n, rho);
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(n);
    told += std::pow(error_of_mean(values), 2);
    truth += mean * mean;
  }
  return std::sqrt(told / truth);
}

TEST(SeriesError, IsThatOfTheMeanHoweverTheValuesHangTogether) {
  for (const double rho : {0.0, 0.3, 0.6, 0.8}) {
    for (const std::size_t n : {6u, 10u, 20u}) {
      EXPECT_GT(told_over_true(n, rho), 0.9) << n << " values, correlation " << rho;
      EXPECT_LT(told_over_true(n, rho), 1.6) << n << " values, correlation " << rho;
    }
    EXPECT_NEAR(told_over_true(400, rho), 1.0, 0.1) << "correlation " << rho;
  }
}

TEST(SeriesError, DoesNotTakeATrendForTenLooksAtOneValue) {
  std::vector<double> trend(10);
  std::iota(trend.begin(), trend.end(), 0.0);
  EXPECT_GT(error_of_mean(trend), 0.25 * trend.back());
}

TEST(SeriesError, SaysNothingOfTooFewOrOfEqualValues) {
  EXPECT_EQ(error_of_mean(std::vector{1.0, 2.0, 3.0}), 0.0);
  EXPECT_EQ(error_of_mean(std::vector(10, 2.0)), 0.0);
}

}  // namespace
}  // namespace granary::monitor
