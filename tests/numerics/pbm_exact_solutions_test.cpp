// The solver against exact solutions: errors no larger than those of a plain cell average code on the same grid,
// moments, and the order with which errors fall. The figures held against are in docs/pbm_equations.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "pbm_solver/verification/exact_solutions.hpp"
#include "pbm_solver/verification/verification.hpp"

namespace granary::pbm {
namespace {

struct Bound {
  const char* name;
  int bins;
  double l1_number;  ///< at most
  double moment_2;   ///< at most, in magnitude
};

class ExactSolution : public ::testing::TestWithParam<Bound> {};

TEST_P(ExactSolution, IsMetAtLeastAsWellAsByAPlainCellAverage) {
  const Bound bound = GetParam();

  const auto v = verify(bound.name, bound.bins);

  ASSERT_TRUE(v) << v.error().message;
  EXPECT_LE(v->l1_number, bound.l1_number);
  EXPECT_LE(std::abs(v->moment_2), bound.moment_2);
  EXPECT_LT(v->drift, 1e-13);
  EXPECT_GE(v->least_number, 0.0);
  // Aggregation alone gives the number but for the time steps; breakage is held within the grid at its lower end.
  EXPECT_LT(std::abs(v->moment_0), std::string(bound.name) == "breakage" ? 3e-3 : 5e-6);
  EXPECT_LT(std::abs(v->moment_1), 1e-4);
}

// L1: the published figures for this scheme, with half a unit of their last digit. M2: the same tables where they give
// it (1-D and constant-2d), else what is measured here plus a tenth.
INSTANTIATE_TEST_SUITE_P(
    Grids, ExactSolution,
    ::testing::Values(Bound{"constant-1d", 37, 0.0505, 0.0015}, Bound{"constant-1d", 73, 0.0155, 0.0105},
                      Bound{"constant-1d", 110, 0.00735, 0.0075}, Bound{"sum-1d", 40, 0.0265, 0.225},
                      Bound{"sum-1d", 80, 0.00665, 0.095}, Bound{"sum-1d", 120, 0.00315, 0.025},
                      Bound{"constant-2d", 16, 0.1255, 0.0135}, Bound{"constant-2d", 32, 0.0355, 0.0080},
                      Bound{"sum-2d", 16, 0.1375, 0.103}, Bound{"sum-2d", 24, 0.0855, 0.016},
                      Bound{"sum-2d", 32, 0.0465, 0.016}, Bound{"breakage", 24, 0.1455, 0.0030},
                      Bound{"breakage", 48, 0.0395, 0.0030}, Bound{"breakage", 96, 0.0086, 0.0030}),
    [](const auto& test) {
      std::string name = std::string(test.param.name) + "_" + std::to_string(test.param.bins);
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

double order(const char* name, int coarse, int fine) {
  const auto a = verify(name, coarse), b = verify(name, fine);
  return std::log(a->l1_number / b->l1_number) / std::log(static_cast<double>(fine) / coarse);
}

TEST(ExactSolutions, AreApproachedWithTheOrderOfTheCellAverage) {
  EXPECT_GT(order("sum-1d", 40, 120), 1.8);
  EXPECT_GT(order("constant-1d", 37, 110), 1.6);
  EXPECT_GT(order("constant-2d", 16, 32), 1.7);
}

TEST(ExactSolutions, AreKeptByTheTimeStepsWithThirdOrder) {
  // On one grid the number's error is the time steps' alone: 100 times the tolerance costs 100^(2/3) times the error or
  // less.
  const auto loose = verify("constant-1d", 40, 1e-3), tight = verify("constant-1d", 40, 1e-5);

  ASSERT_TRUE(loose && tight);
  EXPECT_LT(std::abs(loose->moment_0), 1e-3);
  EXPECT_LT(std::abs(tight->moment_0), std::abs(loose->moment_0) / 20.0);
}

TEST(ExactSolutions, SatisfyTheBalanceTheyAreSaidToSolve) {
  // dM0/dt, M1 and M2 of each density by quadrature, against the moment equations.
  const ClassGrid grid(Grid{{60, 1}, {1e-5, 0.0}, {1.5, 2.0}});
  const ClassGrid grid_2d(Grid{{45, 45}, {1e-4, 1e-4}, {1.5, 1.5}});
  const auto number_and_volume = [](const ClassGrid& g, const std::function<double(double, double)>& f) {
    const BirthGrid cells = exact::cell_content(g, f);
    Birth sum;
    for (int i = 0; i < g.axis(0).size(); ++i)
      for (int j = 0; j < g.axis(1).size(); ++j) sum += cells.at(i, j);
    return sum;
  };
  const Birth constant = number_and_volume(grid, [](double x, double) { return exact::constant_kernel(x, 5.0); });
  EXPECT_NEAR(constant.number, 2.0 / 7.0, 1e-6);
  EXPECT_NEAR(constant.solid_1, 1.0, 1e-6);
  const Birth golovin = number_and_volume(grid, [](double x, double) { return exact::sum_kernel(x, 2.0); });
  EXPECT_NEAR(golovin.number, std::exp(-2.0), 1e-5);
  EXPECT_NEAR(golovin.solid_1, 1.0, 1e-4);
  const Birth broken = number_and_volume(grid, [](double x, double) { return exact::linear_breakage(x, 4.0); });
  EXPECT_NEAR(broken.number, 5.0, 1e-5);
  EXPECT_NEAR(broken.solid_1, 1.0, 1e-5);
  const Birth two = number_and_volume(grid_2d, [](double x, double y) { return exact::constant_kernel_2d(x, y, 5.0); });
  EXPECT_NEAR(two.number, 2.0 / 7.0, 1e-5);
  EXPECT_NEAR(two.solid_2, 1.0, 1e-5);
  const Birth sum_two = number_and_volume(grid_2d, [](double x, double y) { return exact::sum_kernel_2d(x, y, 0.5); });
  EXPECT_NEAR(sum_two.number, std::exp(-1.0), 1e-5);
  EXPECT_NEAR(sum_two.solid_1, 1.0, 1e-5);
}

TEST(ExactSolutions, AreRefusedByAnUnknownName) {
  const auto v = verify("sum-2", {});

  ASSERT_FALSE(v);
  EXPECT_NE(v.error().message.find("Did you mean"), std::string::npos) << v.error().message;
}

}  // namespace
}  // namespace granary::pbm
