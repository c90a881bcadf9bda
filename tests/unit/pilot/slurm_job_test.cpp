// What Slurm says of a job, read.
#include <gtest/gtest.h>

#include <ctime>

#include "pilot/agent/slurm_job.hpp"

namespace granary::pilot {
namespace {

TEST(SlurmJob, ReadsGroupsOfNodesWithTheirCoresAndMemory) {
  const auto groups = node_groups(
      "JobId=7 JobState=RUNNING NodeList=node[1-4] NumNodes=4 ReqB:S:C:T=0:0:*:*   Nodes=node[1-2,4] CPU_IDs=0-3,8 "
      "Mem=4096 GRES=    Nodes=node3 CPU_IDs=5 Mem=0 GRES=gpu:1(IDX:0) MinCPUsNode=1");

  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].nodes, "node[1-2,4]");
  EXPECT_EQ(groups[0].cpus, 5);
  EXPECT_EQ(groups[0].memory_mb, 4096);
  EXPECT_EQ(groups[1].nodes, "node3");
  EXPECT_EQ(groups[1].cpus, 1);
  EXPECT_EQ(groups[1].memory_mb, 0);
}

TEST(SlurmJob, TakesNoGroupForOneWithoutItsCores) {
  EXPECT_TRUE(node_groups("JobId=7 Nodes=node1 Mem=5 CPU_IDs=").empty());
  EXPECT_TRUE(node_groups("").empty());
}

TEST(SlurmJob, CountsIds) {
  EXPECT_EQ(count_ids("0"), 1);
  EXPECT_EQ(count_ids("0-63,128-191"), 128);
  EXPECT_EQ(count_ids("3-1"), 0);
  EXPECT_EQ(count_ids("(null)"), 0);
}

TEST(SlurmJob, FindsAWordByItsWholeKey) {
  const char* line = "NodeName=n1 CPUTot=8 ThreadsPerCore=2 NodeAddr=10.0.0.7 NodeHostName=host7";
  EXPECT_EQ(word(line, "NodeAddr"), "10.0.0.7");
  EXPECT_EQ(word(line, "Node"), "");
  EXPECT_EQ(word(line, "ThreadsPerCore"), "2");
}

TEST(SlurmJob, ReadsTheEndInLocalTime) {
  const auto end = wall_time_of("2026-11-22T09:25:22");
  ASSERT_TRUE(end.has_value());
  const auto seconds = static_cast<std::time_t>(*end);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", std::localtime(&seconds));
  EXPECT_STREQ(text, "2026-11-22T09:25:22");
  EXPECT_FALSE(wall_time_of("Unknown").has_value());
  EXPECT_FALSE(wall_time_of("UNLIMITED").has_value());
}

}  // namespace
}  // namespace granary::pilot
