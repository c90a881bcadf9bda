// Each hard case by its name, and how much work time integration may take.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <functional>
#include <ostream>

#include "pbm_solver/bench/bench_cases.hpp"
#include "pbm_solver/time/simulation.hpp"
#include "pbm_solver/verification/hard_cases.hpp"

namespace granary::pbm {

static void PrintTo(const HardCase& known, std::ostream* out) { *out << known.name; }

namespace {

class HardCases : public ::testing::TestWithParam<HardCase> {};

TEST_P(HardCases, EndWithinTheirBoundsOrAreRefused) {
  const HardResult result = run_hard_case(GetParam());

  for (const std::string& fault : result.faults()) ADD_FAILURE() << GetParam().name << ": " << fault;
}

INSTANTIATE_TEST_SUITE_P(All, HardCases, ::testing::ValuesIn(hard_cases()), [](const auto& one) {
  std::string name;
  for (const char letter : one.param.name)
    if (std::isalnum(static_cast<unsigned char>(letter)) != 0) name += letter;
  return name + std::to_string(one.index);
});

/// Largest error of the number at `times`, against the same grid at a far smaller tolerance.
double time_error(const std::function<bench::BenchCase(double)>& make, double tolerance, double fine,
                  const std::vector<double>& times, WorkCount& work) {
  Alone alone(1);
  const bench::BenchCase a = make(tolerance), b = make(fine);
  Simulation coarse(a.pbm_case, a.start, alone, 1), exact(b.pbm_case, b.start, alone, 1);
  double worst = 0.0;
  for (const double t : times) {
    EXPECT_TRUE(coarse.advance(t) && exact.advance(t));
    worst = std::max(worst, bench::l1_difference(coarse.snapshot().number, exact.snapshot().number));
  }
  work = coarse.work();
  return worst;
}

TEST(TimeError, IsAThousandthInSeventyEvaluationsOfAggregation) {
  WorkCount work;
  const auto make = [](double tolerance) { return bench::aggregation_case(32, tolerance); };

  EXPECT_LT(time_error(make, 1e-2, 1e-7, {8.0}, work), 1e-3);
  EXPECT_LE(work.rhs_evaluations, 70);
  EXPECT_EQ(work.implicit_steps, 0);
}

TEST(TimeError, IsAThousandthIn350EvaluationsOfStiffBreakage) {
  for (const int exponent : {1, 2}) {
    WorkCount work;
    const auto make = [&](double tolerance) {
      return bench::stiff_case(exponent, exponent == 1 ? 3.1e3 : 2.4e4, tolerance);
    };

    EXPECT_LT(time_error(make, 3e-3, 1e-7, {0.02, 0.1, 0.3, 1.0, 2.0, 8.0}, work), 1e-3) << exponent;
    EXPECT_LE(work.rhs_evaluations, 350) << exponent;
    EXPECT_GT(work.implicit_steps, 0);
  }
}

}  // namespace
}  // namespace granary::pbm
