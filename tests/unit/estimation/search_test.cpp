// The searches find what they look for, with results out of order, some of them lost, and one only where it should be.
#include "estimation/search/search.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "estimation/search/methods.hpp"

namespace granary::estimation {
namespace {

constexpr double kTruth[] = {0.35, 0.6};

/// y = a exp(-k t), a = 10^(-1 + 2 p0), k = 10^(-2 + 2 p1), with a relative error of 5 %.
Residuals decay(const Point& p) {
  const auto y = [](double p0, double p1, int t) {
    return std::pow(10.0, -1.0 + 2.0 * p0) * std::exp(-std::pow(10.0, -2.0 + 2.0 * p1) * t);
  };
  Residuals r;
  for (int t = 0; t < 20; ++t) {
    const double data = y(kTruth[0], kTruth[1], t);
    r.push_back((y(p[0], p[1], t) - data) / (0.05 * data + 0.001));
  }
  return r;
}

struct Course {
  Best best;
  long evaluations = 0;
  bool converged = false;
  std::vector<Point> trials;
};

/// `at_once` evaluations in flight, ended in random order; every twentieth fails.
Course run(Method method, Residuals (*model)(const Point&), int dimensions, std::uint64_t seed, int at_once,
           long most) {
  auto search = make_search(method, dimensions, seed);
  Dice order(seed + 100);
  std::vector<Trial> flying;
  Course course;
  while (course.evaluations < most && !search->converged()) {
    while (static_cast<int>(flying.size()) < at_once) {
      flying.push_back(search->ask());
      course.trials.push_back(flying.back().at);
    }
    const auto k = static_cast<std::size_t>(order.below(at_once));
    const Trial ended = flying[k];
    flying.erase(flying.begin() + static_cast<std::ptrdiff_t>(k));
    const bool failed = ++course.evaluations % 20 == 0;
    search->tell(ended.number, failed ? std::nullopt : std::optional(model(ended.at)));
  }
  course.best = search->best();
  course.converged = search->converged();
  return course;
}

class EveryMethod : public testing::TestWithParam<Method> {};

TEST_P(EveryMethod, FindsTheParametersFromResultsOutOfOrderSomeOfThemLost) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Course course = run(GetParam(), decay, 2, seed, 5, 1500);
    EXPECT_NEAR(course.best.at[0], kTruth[0], 0.01) << "seed " << seed << ", " << course.evaluations << " evaluations";
    EXPECT_NEAR(course.best.at[1], kTruth[1], 0.01);
    EXPECT_LT(course.best.cost, 0.1);
  }
}

TEST_P(EveryMethod, TriesTheSameForTheSameSeedAndOrderOfResults) {
  const Course a = run(GetParam(), decay, 2, 7, 3, 120), b = run(GetParam(), decay, 2, 7, 3, 120);
  EXPECT_EQ(a.trials, b.trials);
  EXPECT_NE(a.trials, run(GetParam(), decay, 2, 8, 3, 120).trials);
}

TEST_P(EveryMethod, KeepsWithinTheBoundsAndNeverWaits) {
  auto search = make_search(GetParam(), 3, 5);
  for (int k = 0; k < 200; ++k)  // nobody ever answers
    for (const double x : search->ask().at) {
      EXPECT_GE(x, 0.0);
      EXPECT_LE(x, 1.0);
    }
  search->tell(12345, Residuals{1.0});  // never asked
  EXPECT_EQ(search->told(), 0);
}

INSTANTIATE_TEST_SUITE_P(Search, EveryMethod, testing::ValuesIn(kMethods), [](const auto& tested) {
  std::string name = name_of(tested.param);
  std::erase_if(name, [](char c) { return c == '-'; });
  return name;
});

/// A wide hollow at 0.2 that ends at cost 2, and a narrow one at 0.85 that ends at 0.
Residuals two_hollows(const Point& p) {
  double wide = 0.0, narrow = 0.0;
  for (const double x : p) {
    wide += std::pow((x - 0.2) / 0.3, 2);
    narrow += std::pow((x - 0.85) / 0.2, 2);
  }
  return {std::sqrt(2.0 * std::min(2.0 + wide, 4.0 * narrow))};
}

TEST(Hybrid, LeavesAHollowThatIsNotTheDeepestMoreOftenThanASingleDescent) {
  int hybrid = 0, single = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    hybrid += run(Method::hybrid, two_hollows, 2, seed, 4, 3000).best.cost < 0.1;
    single += run(Method::cma_es, two_hollows, 2, seed, 4, 3000).best.cost < 0.1;
  }
  EXPECT_GT(hybrid, single + 2);
}

TEST(LeastSquares, NeedsFewerEvaluationsThanTheGlobalSearches) {
  const long local = run(Method::least_squares, decay, 2, 1, 4, 3000).evaluations;
  EXPECT_LT(2 * local, run(Method::cma_es, decay, 2, 1, 4, 3000).evaluations);
}

TEST(Search, GoesOnFromWhatWasKnownBefore) {
  auto search = make_search(Method::hybrid, 2, 3);
  search->inform({kTruth[0], kTruth[1]}, decay({kTruth[0], kTruth[1]}));
  EXPECT_LT(search->best().cost, 1e-12);
  EXPECT_EQ(search->best().trial, -1);
}

}  // namespace
}  // namespace granary::estimation
