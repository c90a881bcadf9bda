#include "pilot/launch/command.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace granary::pilot {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

Launch two_ranks_of_two_threads() {
  Launch launch;
  launch.attempt = {TaskId{4}, 2};
  launch.spec.name = "dem";
  launch.spec.command = {"prog", "-in", "a b"};
  launch.spec.ranks = 2;
  launch.spec.threads = 2;
  launch.dir = "/run";
  launch.cores = {1, 2, 3, 4};
  launch.mark = "mark";
  return launch;
}

TEST(Command, StartsRanksPinnedByARankFileOfPhysicalCores) {
  Machine machine = stated_machine(1, 6);
  machine.nodes[0].cpus = {0, 2, 4, 6, 8, 10};
  const Launch launch = two_ranks_of_two_threads();

  EXPECT_EQ(rank_file_text(launch, machine), "rank 0=localhost slot=2,4\nrank 1=localhost slot=6,8\n");
  EXPECT_THAT(
      mpirun_argv(launch, {}, "/run/dem.ranks", true),
      ElementsAre("mpirun", "--allow-run-as-root", "-n", "2", "--mca", "pml", "ob1", "--mca", "btl", "self,vader",
                  "--mca", "rmaps_rank_file_physical", "1", "--rankfile", "/run/dem.ranks", "prog", "-in", "a b"));
}

TEST(Command, AllowsRootOnlyForRootAndLeavesTheTransportToWhoeverSetIt) {
  const auto argv = mpirun_argv(two_ranks_of_two_threads(), {"OMPI_MCA_pml=ucx"}, "r", false);

  EXPECT_THAT(argv, Not(Contains("--allow-run-as-root")));
  EXPECT_THAT(argv, Not(Contains("ob1")));
}

TEST(Command, OversubscribesOnlyWithFewerCoresThanRanks) {
  Launch launch = two_ranks_of_two_threads();
  launch.cores = {0};

  EXPECT_THAT(mpirun_argv(launch, {}, "r", false), Contains("--oversubscribe"));
  EXPECT_THAT(mpirun_argv(two_ranks_of_two_threads(), {}, "r", false), Not(Contains("--oversubscribe")));
}

TEST(Command, TellsThreadsAndAttemptInTheEnvironmentAndLetsTheTaskHaveTheLastWord) {
  Launch launch = two_ranks_of_two_threads();
  launch.spec.env = {{"OMP_PLACES", "threads"}, {"X", "1"}};

  const auto env = environment_of(launch, {"PATH=/bin", "OMP_NUM_THREADS=64"});

  EXPECT_THAT(env, ElementsAre("PATH=/bin", "OMP_NUM_THREADS=2", "OMP_PLACES=threads", "OMP_PROC_BIND=close",
                               "GRANARY_MARK=mark", "GRANARY_TASK=dem", "GRANARY_ATTEMPT=2", "X=1"));
  EXPECT_EQ(variable(env, "GRANARY_TASK"), "dem");
  EXPECT_EQ(variable(env, "GRANARY"), "");
}

TEST(Command, NamesTheProgramAndThePathSearchedWhenThereIsNone) {
  const auto missing = find_executable("nosuch-program", "/", "/bin:/usr/bin");
  ASSERT_FALSE(missing.has_value());
  EXPECT_THAT(missing.error().message, HasSubstr("nosuch-program: no such program in PATH (/bin:/usr/bin)"));
  const auto plain = find_executable("./passwd", "/etc", "");
  ASSERT_FALSE(plain.has_value());
  EXPECT_THAT(plain.error().message, HasSubstr("is not executable"));
  EXPECT_EQ(find_executable("true", "/", "/nowhere:/bin").value_or(""), "/bin/true");
}

}  // namespace
}  // namespace granary::pilot
