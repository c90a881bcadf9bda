#include <gtest/gtest.h>

#include <cmath>

#include "pbm_solver/model/daughter_distribution.hpp"

namespace granary::pbm {
namespace {

constexpr Breakage::Daughters kAll[] = {Breakage::Daughters::uniform_binary, Breakage::Daughters::halves,
                                        Breakage::Daughters::same_composition};

BirthGrid births_from(const ClassGrid& grid, const DaughterDistribution& daughters, std::size_t parent) {
  Broken broken{std::vector<double>(grid.size()), std::vector<double>(grid.size()), std::vector<double>(grid.size())};
  broken.number[parent] = 3.0;
  broken.liquid[parent] = 0.7;
  broken.gas[parent] = 0.4;
  BirthGrid births(grid);
  daughters.add_births(grid, broken, births);
  return births;
}

Birth sum_of(const ClassGrid& grid, const BirthGrid& births) {
  Birth sum = births.oversize();
  for (int i = 0; i < grid.axis(0).size(); ++i)
    for (int j = 0; j < grid.axis(1).size(); ++j) sum += births.at(i, j);
  return sum;
}

TEST(Daughters, AreTwoAndHoldAllOfTheParent) {
  for (const double ratio : {1.3, 2.0, 3.0})
    for (const auto model : kAll) {
      const ClassGrid grid(Grid{{12, 9}, {1.0, 0.5}, {ratio, 2.2}});
      const DaughterDistribution daughters(grid, model);
      int broke = 0;
      for (std::size_t k = 0; k < grid.size(); ++k) {
        if (!daughters.divisible(k)) continue;
        ++broke;
        const Birth sum = sum_of(grid, births_from(grid, daughters, k));
        EXPECT_NEAR(sum.number, 6.0, 1e-12);
        EXPECT_NEAR(sum.solid_1, 3.0 * grid.solid_1()[k], 1e-12 * sum.solid_1);
        EXPECT_NEAR(sum.solid_2, 3.0 * grid.solid_2()[k], 1e-12 * sum.solid_2);
        EXPECT_NEAR(sum.liquid, 0.7, 1e-12);
        EXPECT_NEAR(sum.gas, 0.4, 1e-12);
      }
      EXPECT_GT(broke, 40);
    }
}

TEST(Daughters, LieWithinTheCellsTheyAreCountedIn) {
  for (const auto model : kAll) {
    const ClassGrid grid(Grid{{10, 10}, {1.0, 1.0}, {1.8, 1.8}});
    const DaughterDistribution daughters(grid, model);
    const BirthGrid births = births_from(grid, daughters, grid.index(9, 7));
    for (int i = 0; i < 10; ++i)
      for (int j = 0; j < 10; ++j) {
        const Birth& b = births.at(i, j);
        if (b.number == 0.0) continue;
        EXPECT_GT(b.number, 0.0);
        EXPECT_GE(b.solid_1 / b.number, std::max(1.0, grid.axis(0).lower_edge(i)) * (1 - 1e-12));
        EXPECT_LE(b.solid_1 / b.number, grid.axis(0).lower_edge(i + 1) * (1 + 1e-12));
        EXPECT_GE(b.solid_2 / b.number, std::max(1.0, grid.axis(1).lower_edge(j)) * (1 - 1e-12));
        EXPECT_LE(b.solid_2 / b.number, grid.axis(1).lower_edge(j + 1) * (1 + 1e-12));
      }
  }
}

TEST(Daughters, AreUniformOverTheCells) {
  // Away from the ends the number in a cell is 2 (its area) / (x1 x2) of the parents.
  const ClassGrid grid(Grid{{12, 12}, {1e-3, 1e-3}, {2.0, 2.0}});
  const DaughterDistribution daughters(grid, Breakage::Daughters::uniform_binary);

  const BirthGrid births = births_from(grid, daughters, grid.index(11, 10));

  const auto width = [](const SolidAxis& axis, int i) { return axis.lower_edge(i + 1) - axis.lower_edge(i); };
  for (int i = 1; i < 10; ++i)
    for (int j = 1; j < 9; ++j) {
      const double expected = 3.0 * 2.0 * width(grid.axis(0), i) * width(grid.axis(1), j) /
                              (grid.axis(0).pivot(11) * grid.axis(1).pivot(10));
      EXPECT_NEAR(births.at(i, j).number, expected, 1e-12 * expected);
    }
}

TEST(Daughters, OfTheSameCompositionKeepIt) {
  const ClassGrid grid(Grid{{14, 14}, {1.0, 1.0}, {1.5, 1.5}});
  const DaughterDistribution daughters(grid, Breakage::Daughters::same_composition);

  const BirthGrid births = births_from(grid, daughters, grid.index(13, 9));

  const double composition = grid.axis(0).pivot(13) / grid.axis(1).pivot(9);
  for (int i = 0; i < 14; ++i)
    for (int j = 0; j < 14; ++j)
      if (births.at(i, j).number > 0.0) {
        EXPECT_NEAR(births.at(i, j).solid_1 / births.at(i, j).solid_2, composition, 1e-12 * composition);
      }
}

TEST(Daughters, OfTheSmallestClassesAreNone) {
  const ClassGrid grid(Grid{{5, 5}, {1.0, 1.0}, {2.0, 1.5}});
  const DaughterDistribution daughters(grid, Breakage::Daughters::uniform_binary);

  EXPECT_FALSE(daughters.divisible(grid.index(0, 4)));
  EXPECT_FALSE(daughters.divisible(grid.index(4, 1)));  // 1.5 < 2
  EXPECT_TRUE(daughters.divisible(grid.index(1, 2)));   // exactly 2, and 2.25
}

}  // namespace
}  // namespace granary::pbm
