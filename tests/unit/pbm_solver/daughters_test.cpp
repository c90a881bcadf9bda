#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "pbm_solver/model/breakage_operator.hpp"
#include "pbm_solver/model/simd/lanes.hpp"

namespace granary::pbm {
namespace {

constexpr Breakage::Daughters kAll[] = {Breakage::Daughters::uniform_binary, Breakage::Daughters::halves,
                                        Breakage::Daughters::same_composition};

TEST(Fragments, AreTwoAndHoldAllOfTheParent) {
  for (const double ratio : {1.3, 2.0, 3.0})
    for (const auto model : kAll) {
      const ClassGrid grid(Grid{{12, 9}, {1.0, 0.5}, {ratio, 2.2}});
      const Fragments fragments(grid, model);
      int broke = 0;
      for (std::size_t k = 0; k < grid.size(); ++k) {
        if (!fragments.divisible(k)) continue;
        ++broke;
        double number = 0.0, solid_1 = 0.0, solid_2 = 0.0;
        for (std::size_t to = 0; to < grid.size(); ++to) {
          const double weight = fragments.weight(to, k);
          EXPECT_GE(weight, 0.0);
          number += weight, solid_1 += weight * grid.solid_1()[to], solid_2 += weight * grid.solid_2()[to];
        }
        EXPECT_NEAR(number, 2.0, 1e-12);
        EXPECT_NEAR(solid_1, grid.solid_1()[k], 1e-12 * solid_1);
        EXPECT_NEAR(solid_2, grid.solid_2()[k], 1e-12 * solid_2);
      }
      EXPECT_GT(broke, 40);
    }
}

TEST(Fragments, AreNoLargerThanTheParentInEitherSolid) {
  for (const auto model : kAll) {
    const ClassGrid grid(Grid{{10, 10}, {1.0, 1.0}, {1.8, 1.8}});
    const Fragments fragments(grid, model);
    for (std::size_t k = 0; k < grid.size(); ++k)
      for (std::size_t to = 0; to < grid.size(); ++to)
        if (fragments.weight(to, k) != 0.0) {
          EXPECT_LE(to / 10, k / 10);
          EXPECT_LE(to % 10, k % 10);
        }
  }
}

TEST(Fragments, AreUniformOverTheCells) {
  // Away from the ends the mean of a cell is its pivot, and the number there 2 (the cell's area) / (x1 x2).
  const ClassGrid grid(Grid{{12, 12}, {1e-3, 1e-3}, {2.0, 2.0}});
  const Fragments fragments(grid, Breakage::Daughters::uniform_binary);

  const auto width = [](const SolidAxis& axis, int i) { return axis.lower_edge(i + 1) - axis.lower_edge(i); };
  for (int i = 2; i < 9; ++i)
    for (int j = 2; j < 8; ++j) {
      const double expected =
          2.0 * width(grid.axis(0), i) * width(grid.axis(1), j) / (grid.axis(0).pivot(11) * grid.axis(1).pivot(10));
      EXPECT_NEAR(fragments.weight(grid.index(i, j), grid.index(11, 10)), expected, 1e-12 * expected);
    }
}

TEST(Fragments, OfTheSameCompositionKeepItOnTheDiagonal) {
  const ClassGrid grid(Grid{{14, 14}, {1.0, 1.0}, {1.5, 1.5}});
  const Fragments fragments(grid, Breakage::Daughters::same_composition);

  double off = 0.0;
  for (std::size_t to = 0; to < grid.size(); ++to)
    off += std::abs(fragments.weight(to, grid.index(13, 13)) * (grid.solid_1()[to] - grid.solid_2()[to]));

  // Tensor weights of one mean (m, m) go to four pivots, two of them off the diagonal by a cell, never more.
  for (int i = 0; i < 14; ++i)
    for (int j = 0; j < 14; ++j)
      if (std::abs(i - j) > 1) {
        EXPECT_EQ(fragments.weight(grid.index(i, j), grid.index(13, 13)), 0.0);
      }
  EXPECT_LT(off, 0.3 * grid.solid()[grid.index(13, 13)]);
}

TEST(Fragments, OfTheSmallestClassesAreNone) {
  const ClassGrid grid(Grid{{5, 5}, {1.0, 1.0}, {2.0, 1.5}});
  const Fragments fragments(grid, Breakage::Daughters::uniform_binary);

  EXPECT_FALSE(fragments.divisible(grid.index(0, 4)));
  EXPECT_FALSE(fragments.divisible(grid.index(4, 1)));  // 1.5 < 2
  EXPECT_TRUE(fragments.divisible(grid.index(1, 2)));   // exactly 2, and 2.25
}

const BreakageTable kTable{{10.0, 1000.0}, {1.0, 2.0}, {{{0.5, 2.0}}, {{0.75, 1.0}, {0.0625, 4.0}}}};

TEST(Fragments, OfATableHoldAllOfTheParentAndAreAsManyAsItSays) {
  for (const double ratio : {1.3, 2.0, 3.0}) {
    const ClassGrid grid(Grid{{14, 9}, {1e-3, 5e-4}, {ratio, 2.2}});
    const Fragments fragments(grid, Breakage::Daughters::table, kTable);
    for (std::size_t k = 0; k < grid.size(); ++k) {
      if (!fragments.divisible(k)) continue;
      double number = 0.0, solid_1 = 0.0, solid_2 = 0.0;
      for (std::size_t to = 0; to < grid.size(); ++to) {
        const double weight = fragments.weight(to, k);
        EXPECT_GE(weight, 0.0);
        number += weight, solid_1 += weight * grid.solid_1()[to], solid_2 += weight * grid.solid_2()[to];
      }
      EXPECT_NEAR(solid_1, grid.solid_1()[k], 1e-12 * solid_1);
      EXPECT_NEAR(solid_2, grid.solid_2()[k], 1e-12 * solid_2);
      // 2 below the table's first parent, 5 above its last, in between linear in ln of the volume.
      const double at = std::clamp(std::log(grid.solid()[k] / 10.0) / std::log(100.0), 0.0, 1.0);
      const bool whole = 0.0625 * grid.solid_1()[k] >= 1e-3 && 0.0625 * grid.solid_2()[k] >= 5e-4;
      if (whole || at == 0.0) {
        EXPECT_NEAR(number, 2.0 + 3.0 * at, 1e-12 * number);
      }
    }
  }
}

TEST(Fragments, OfATableOfTwoHalvesAreThoseOfHalvesToTheBit) {
  const ClassGrid grid(Grid{{12, 9}, {1.0, 0.5}, {1.3, 2.2}});
  const Fragments halves(grid, Breakage::Daughters::halves);
  const Fragments table(grid, Breakage::Daughters::table, {{1.0}, {1.0}, {{{0.5, 2.0}}}});

  for (std::size_t k = 0; k < grid.size(); ++k) {
    EXPECT_EQ(table.divisible(k), halves.divisible(k));
    for (std::size_t to = 0; to < grid.size(); ++to) EXPECT_EQ(table.weight(to, k), halves.weight(to, k));
  }
}

TEST(Fragments, OfATableThatHitPivotsStandOnThem) {
  // One solid that doubles from class to class: a parent of 16 gives one of 8 and eight of 1.
  const ClassGrid grid(Grid{{6, 1}, {1.0, 0.0}, {2.0, 2.0}});
  const Fragments fragments(grid, Breakage::Daughters::table, {{16.0}, {1.0}, {{{0.5, 1.0}, {1.0 / 16.0, 8.0}}}});

  EXPECT_DOUBLE_EQ(fragments.weight(0, 4), 8.0);
  EXPECT_DOUBLE_EQ(fragments.weight(3, 4), 1.0);
  for (const std::size_t none : {1u, 2u, 4u, 5u}) EXPECT_EQ(fragments.weight(none, 4), 0.0);
  // Of a parent of 2, eight of 1/8 would be smaller than the first pivot: together with the half they are two of 1.
  EXPECT_DOUBLE_EQ(fragments.weight(0, 1), 2.0);
}

TEST(Fragments, AreTakenBackBySolvingForThem) {
  // (1 - gamma A) y computed by adding, then solved: y comes back, for any model and both kinds of lanes.
  for (const auto model : {kAll[0], kAll[1], kAll[2], Breakage::Daughters::table})
    for (const int lanes : {1, 8}) {
      const ClassGrid grid(Grid{{9, 7}, {1.0, 0.5}, {1.9, 2.2}});
      const Fragments fragments(grid, model, kTable);
      const auto width = static_cast<std::size_t>(lanes);
      const std::size_t n = grid.size() * width;
      LaneVector selection(n), y(n), scratch(2 * n);
      for (std::size_t k = 0; k < n; ++k) {
        y[k] = 1.0 + static_cast<double>(k % 13);
        if (fragments.divisible(k / width)) selection[k] = std::pow(10.0, static_cast<double>(k % 7) - 2.0);
      }
      const simd::GridView view{9, 7, grid.axis(0).pivots().data(), grid.axis(1).pivots().data()};
      for (const double* scale : {static_cast<const double*>(nullptr), grid.solid().data()}) {
        LaneVector r = y;
        simd::operations(lanes).add_breakage(view, fragments.view(), selection.data(), scale, -0.3, y.data(),
                                             scratch.data(), r.data());

        simd::operations(lanes).solve_breakage(view, fragments.view(), selection.data(), scale, 0.3, scratch.data(),
                                               r.data());

        for (std::size_t k = 0; k < n; ++k) EXPECT_NEAR(r[k], y[k], 1e-9 * y[k]);
      }
    }
}

}  // namespace
}  // namespace granary::pbm
