#include "pbm_solver/verification/cell_average.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "pbm_solver/model/class_grid.hpp"

namespace granary::pbm {
namespace {

TEST(SolidAxis, HoldsEachPivotInTheMiddleOfItsCell) {
  const SolidAxis axis(10, 2.0, 1.7);

  for (int i = 1; i + 1 < axis.size(); ++i)
    EXPECT_NEAR(0.5 * (axis.lower_edge(i) + axis.lower_edge(i + 1)), axis.pivot(i), 1e-12 * axis.pivot(i));
}

TEST(SolidAxis, PutsEveryPivotInItsOwnCellAndSumsBetweenTheEdges) {
  for (const double ratio : {1.1, 1.5, 2.0, 3.0, 10.0}) {
    const SolidAxis axis(12, 5e-16, ratio);
    for (int i = 0; i < axis.size(); ++i) {
      EXPECT_EQ(axis.cell(axis.pivot(i)), i);
      for (int k = 0; k < axis.size(); ++k) {
        const double sum = axis.pivot(i) + axis.pivot(k);
        const int cell = axis.sum_cell(i, k);
        EXPECT_EQ(cell, axis.sum_cell(k, i));
        if (sum > axis.pivot(axis.size() - 1) * (1 + 1e-12)) {
          EXPECT_EQ(cell, axis.size());
        } else {
          EXPECT_GE(sum, axis.lower_edge(cell) * (1 - 1e-9));
          EXPECT_LE(sum, axis.lower_edge(cell + 1) * (1 + 1e-9));
        }
      }
    }
  }
}

TEST(SolidAxis, IsOneClassOfNothingForASolidThatIsAbsent) {
  const SolidAxis axis(1, 0.0, 2.0);

  EXPECT_TRUE(axis.absent());
  EXPECT_EQ(axis.sum_cell(0, 0), 0);
}

RC_GTEST_PROP(SolidAxis, SharesAMeanSoThatNumberAndVolumeStay, ()) {
  const double ratio = 1.05 + *rc::gen::inRange(0, 900) / 100.0;
  const SolidAxis axis(9, 1.0, ratio);
  const int cell = *rc::gen::inRange(0, axis.size());
  const double low = std::max(axis.lower_edge(cell), axis.pivot(0)), high = axis.lower_edge(cell + 1);
  const double mean = low + (high - low) * *rc::gen::inRange(0, 1000) / 1000.0;

  const PivotShare share = axis.share(cell, mean);

  RC_ASSERT(share.to_lower >= 0.0);
  RC_ASSERT(share.to_upper >= 0.0);
  RC_ASSERT(std::abs(share.to_lower + share.to_upper - 1.0) < 1e-15);
  const double upper = share.to_upper > 0.0 ? axis.pivot(share.lower + 1) : 0.0;
  RC_ASSERT(std::abs(share.to_lower * axis.pivot(share.lower) + share.to_upper * upper - mean) <= 1e-14 * mean);
}

TEST(CellAverage, KeepsNumberBothSolidsLiquidAndGas) {
  const ClassGrid grid(Grid{{7, 5}, {1.0, 0.3}, {2.1, 3.0}});
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> one(0.0, 1.0);
  BirthGrid births(grid);
  Birth all;
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 5; ++j)
      for (int n = 0; n < 3; ++n) {
        const auto inside = [&](const SolidAxis& axis, int cell) {
          const double low = std::max(axis.lower_edge(cell), axis.pivot(0));
          return low + one(random) * (axis.lower_edge(cell + 1) - low);
        };
        const double number = std::pow(10.0, 6 * one(random));
        const Birth birth{number, number * inside(grid.axis(0), i), number * inside(grid.axis(1), j), one(random),
                          one(random)};
        births.at(i, j) += birth;
        all += birth;
      }
  std::vector<double> number(grid.size()), liquid(grid.size()), gas(grid.size());

  share_births(grid, births, {number, liquid, gas});

  Birth shared;
  for (std::size_t k = 0; k < grid.size(); ++k)
    shared += {number[k], number[k] * grid.solid_1()[k], number[k] * grid.solid_2()[k], liquid[k], gas[k]};
  EXPECT_NEAR(shared.number / all.number, 1.0, 1e-13);
  EXPECT_NEAR(shared.solid_1 / all.solid_1, 1.0, 1e-13);
  EXPECT_NEAR(shared.solid_2 / all.solid_2, 1.0, 1e-13);
  EXPECT_NEAR(shared.liquid / all.liquid, 1.0, 1e-13);
  EXPECT_NEAR(shared.gas / all.gas, 1.0, 1e-13);
}

}  // namespace
}  // namespace granary::pbm
