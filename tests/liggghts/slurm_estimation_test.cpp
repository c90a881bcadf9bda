// A coupled campaign that fits parameters, as a job of a real Slurm of four virtual nodes: what the DEM and the balance
// leave idle is on all of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/results/campaign_results.hpp"
#include "tests/support/agent_tasks.hpp"
#include "tests/support/slurm_cluster.hpp"
#include "tests/support/small_estimation.hpp"

namespace granary::test {
namespace {

constexpr int kNodes = 4, kCores = 2;

TEST(SlurmEstimation, SpreadsItsFillersOverAllNodesWhileTheCampaignRunsAndEndsWithTheFinalRun) {
  const SlurmCluster cluster(kNodes, kCores);
  if (!cluster.why_not().empty()) GTEST_SKIP() << "Slurm cannot be started here: " << cluster.why_not();
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  const auto submitted = granary(
      small_estimation("submit", dir,
                       {"/resources={\"nodes\": 4, \"walltime\": \"10 min\", \"stop_before\": \"1 min\"}",
                        "/coupling/most_rounds=2", "/coupling/least_rounds=2", "/dem/longest_burst=\"0.12 s\""}));
  ASSERT_EQ(0, submitted.exit_code) << submitted.err;

  ASSERT_TRUE(wait_until([&] { return fs::exists(dir / "report.html"); }, 200.0)) << granary({"status", dir}).out;

  const auto results = read_results(dir / "results.h5");
  ASSERT_TRUE(results) << results.error().message;
  EXPECT_EQ(4u, results->bursts.size());
  std::set<std::int64_t> nodes;
  for (const auto& entry : results->timeline)
    if (entry.kind == "estimation")
      for (const std::int64_t core : entry.cores) nodes.insert(core / kCores);
  EXPECT_THAT(nodes, testing::ElementsAre(0, 1, 2, 3));
  // The DEM kept its core: what was put aside for it was resumed or started again, and none of it was lost.
  EXPECT_TRUE(records(dir, "task.lost").empty());
  EXPECT_EQ(1u, records(dir, "estimation.over").size());
  if (!records(dir, "estimation.final").empty()) {
    EXPECT_TRUE(fs::exists(dir / "final/0002/out.h5"));
  }
  cluster.wait_until_idle();
}

}  // namespace
}  // namespace granary::test
