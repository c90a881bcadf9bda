#include "controller/bench/estimate.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "controller/bench/dem_run.hpp"

namespace granary::bench {
namespace {

TEST(Estimate, OfOneRunIsThatOfItsBatches) {
  const Estimate e = estimate({"x", "", {{1.0, 2.0, 3.0, 4.0}}});

  EXPECT_DOUBLE_EQ(e.mean, 2.5);
  EXPECT_DOUBLE_EQ(e.error, std::sqrt(5.0 / 3.0 / 4.0));
}

TEST(Estimate, TakesWhatAllRunsShareForNoNoise) {
  const Estimate e = estimate({"x", "", {{1.0, 5.0, 9.0}, {1.0, 5.0, 9.0}}});

  EXPECT_DOUBLE_EQ(e.mean, 5.0);
  EXPECT_DOUBLE_EQ(e.error, 0.0);
}

TEST(Estimate, SeesWhatLastsLongerThanABatch) {
  // Each run has a level of its own, its batches hardly differ: there are three values, not nine.
  const Estimate e = estimate({"x", "", {{1.0, 1.0, 1.0}, {2.0, 2.0, 2.0}, {3.0, 3.0, 3.0}}});

  EXPECT_NEAR(e.error, 1.0 / std::sqrt(3.0), 1e-12);
}

TEST(Estimate, CoversTheTruthAsOftenAsItSays) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(10.0, 2.0);
  int outside = 0;
  constexpr int kTrials = 2000;

  for (int trial = 0; trial < kTrials; ++trial) {
    Measured m{"x", "", std::vector<std::vector<double>>(4, std::vector<double>(6))};
    for (auto& run : m.run)
      for (double& x : run) x = noise(random);
    const Estimate e = estimate(m);
    outside += std::abs(e.mean - 10.0) > largest_z(1, 20, 0.05) * e.error;
  }

  // At most one in twenty: the larger of two errors is on the safe side.
  EXPECT_LT(outside, 0.06 * kTrials);
  EXPECT_GT(outside, 0.005 * kTrials);
}

TEST(LargestZ, IsStudentsTwoSided) {
  EXPECT_NEAR(largest_z(1, 10, 0.05), 2.228, 1e-3);
  EXPECT_NEAR(largest_z(5, 10, 0.05), 3.169, 1e-3);  // each at 0.01
}

TEST(Loops, AreReadFromWhatLiggghtsPrints) {
  const auto loops = read_loops(
      "Loop time of 0.5 on 1 procs for 1000 steps with 2300 atoms, finish time now\n\nPair  time (%) = 0.2 (40)\n"
      "Loop time of 2e-05 on 2 procs for 0 steps with 2299 atoms, finish time now\n");

  ASSERT_EQ(loops.size(), 2U);
  EXPECT_DOUBLE_EQ(loops[0].ms_per_step(), 0.5);
  EXPECT_DOUBLE_EQ(loops[0].pair_seconds, 0.2);
  EXPECT_EQ(loops[1].particles, 2299);
  EXPECT_DOUBLE_EQ(loops[1].ms_per_step(), 0.0);
}

}  // namespace
}  // namespace granary::bench
