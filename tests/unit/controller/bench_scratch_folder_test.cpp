#include "controller/bench/scratch_folder.hpp"

#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace granary::bench {
namespace {

namespace fs = std::filesystem;

TEST(ScratchFolder, IsGoneAtItsEndWithAllThatIsInIt) {
  fs::path path;
  {
    const auto scratch = ScratchFolder::make(fs::temp_directory_path());
    ASSERT_TRUE(scratch);
    path = scratch->path();
    std::ofstream(path / "file") << "text";
    ASSERT_TRUE(fs::exists(path / "file"));
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST(ScratchFolder, IsGoneWhenTheProgramIsInterrupted) {
  const fs::path parent = fs::temp_directory_path() / ("granary-interrupted-" + std::to_string(getpid()));
  fs::create_directory(parent);
  const auto interrupted = [&](int signal) {
    const auto scratch = ScratchFolder::make(parent);
    fs::create_directory(scratch->path() / "burst");
    (void)kill(getpid(), signal);
    pause();
  };
  testing::FLAGS_gtest_death_test_style = "fast";
  EXPECT_EXIT(interrupted(SIGTERM), testing::ExitedWithCode(128 + SIGTERM), "interrupted .*granary-bench-");
  EXPECT_EXIT(interrupted(SIGINT), testing::ExitedWithCode(128 + SIGINT), "interrupted .*granary-bench-");
  EXPECT_TRUE(fs::is_empty(parent));
  fs::remove_all(parent);
}

TEST(ScratchFolder, IsNotMadeWhereNoneCanBe) { EXPECT_FALSE(ScratchFolder::make("/nowhere at all")); }

}  // namespace
}  // namespace granary::bench
