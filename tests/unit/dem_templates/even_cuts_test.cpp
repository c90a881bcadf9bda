// Slices of a line with equal loads.
#include "dem_templates/plugin/balance/even_cuts.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace granary::dem {
namespace {

TEST(EvenCuts, GiveEachSliceAsMuch) {
  const std::vector<double> load{6, 2, 1, 1, 0, 0, 0, 2};  // of 1/8 each
  const std::vector<double> cuts = even_cuts(load, {0.0, 0.5, 1.0}, 0.01);
  ASSERT_EQ(cuts.size(), 3u);
  EXPECT_DOUBLE_EQ(cuts[1], 1.0 / 8.0);
  EXPECT_DOUBLE_EQ(imbalance(load, {0.0, 0.5, 1.0}), 10.0 / 6.0);
  EXPECT_DOUBLE_EQ(imbalance(load, cuts), 1.0);
}

TEST(EvenCuts, MoveNothingFartherThanToTheNextSlice) {
  std::vector<double> load(100, 0.0);
  load[99] = 1.0;
  const std::vector<double> now{0.0, 0.25, 0.5, 0.75, 1.0}, cuts = even_cuts(load, now, 0.02);
  for (std::size_t k = 1; k < 4; ++k) {
    EXPECT_LE(cuts[k], now[k + 1] - 0.02 + 1e-12) << k;
    EXPECT_GE(cuts[k], cuts[k - 1] + 0.02 - 1e-12) << k;
  }
}

TEST(EvenCuts, ComeToABalanceInAFewRounds) {
  std::vector<double> load(1024);
  for (std::size_t k = 0; k < load.size(); ++k) load[k] = k < 100 ? 50.0 : 1.0;
  std::vector<double> cuts{0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0};
  for (int round = 0; round < 10; ++round) cuts = even_cuts(load, cuts, 0.005);
  EXPECT_LT(imbalance(load, cuts), 1.001);
}

TEST(EvenCuts, StayWhereThereIsNoLoad) {
  const std::vector<double> now{0.0, 0.3, 1.0};
  EXPECT_EQ(even_cuts(std::vector<double>(16, 0.0), now, 0.1), now);
  EXPECT_EQ(imbalance(std::vector<double>(16, 0.0), now), 1.0);
}

}  // namespace
}  // namespace granary::dem
