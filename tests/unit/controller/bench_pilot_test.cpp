// The simulated part of `granary bench pilot`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include "controller/bench/pilot_simulation.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(PilotSimulation, RunsEveryTaskNoShorterThanTheLowerBoundAndLeavesNoFile) {
  const fs::path dir = fs::temp_directory_path() / ("granary_simulation_" + std::to_string(getpid()));
  fs::create_directories(dir);

  const auto run = simulate_pilot({20, 8, 2000}, dir);

  ASSERT_TRUE(run.has_value()) << run.error().message;
  EXPECT_EQ(run->finished, 2000);
  EXPECT_GE(run->makespan, run->lower_bound);
  EXPECT_LE(run->core_use, 1.0);
  EXPECT_GT(run->core_use, 0.3);
  EXPECT_GT(run->journal_bytes, 2000 * 300.0) << "the journal is real";
  EXPECT_TRUE(fs::is_empty(dir));
  fs::remove_all(dir);
}

TEST(PilotSimulation, IsTheSameEachTime) {
  const fs::path dir = fs::temp_directory_path() / ("granary_simulation_twice_" + std::to_string(getpid()));
  fs::create_directories(dir);

  const auto one = simulate_pilot({5, 4, 300}, dir), two = simulate_pilot({5, 4, 300}, dir);

  ASSERT_TRUE(one.has_value() && two.has_value());
  EXPECT_EQ(one->makespan, two->makespan);
  EXPECT_EQ(one->core_use, two->core_use);
  fs::remove_all(dir);
}

TEST(PilotSimulation, ReadsItsSizeAndSaysWhatIsWrong) {
  const auto size = parse_simulation_size("nodes=10,cores=64,tasks=1000");

  ASSERT_TRUE(size.has_value());
  EXPECT_EQ(size->nodes, 10);
  EXPECT_EQ(size->cores, 64);
  EXPECT_EQ(size->tasks, 1000);
  for (const char* wrong : {"", "nodes=1,cores=2", "nodes=0,cores=1,tasks=1", "nodes=x,cores=1,tasks=1", "node=1"})
    EXPECT_THAT(parse_simulation_size(wrong).error().message, HasSubstr("Write nodes=10000")) << wrong;
}

}  // namespace
}  // namespace granary::bench
