// A campaign whose pilot is killed in the midst of its work.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/granary_program.hpp"

namespace granary::test {

/// Runs `granary ARGUMENTS` and kills its pilot as soon as `sign` is there (both in the campaign's folder `dir`), or
/// after `seconds`. To be called with ASSERT_NO_FATAL_FAILURE.
inline void run_and_kill(std::vector<std::string> arguments, const std::filesystem::path& dir,
                         const std::filesystem::path& sign, double seconds) {
  arguments.insert(arguments.begin(), (kPrograms / "granary").string());
  std::thread killer([&] {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (!std::filesystem::exists(dir / sign) && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    int pid = 0;
    std::ifstream(dir / "pilot.lock") >> pid;
    ASSERT_GT(pid, 1);
    EXPECT_EQ(0, ::kill(pid, SIGKILL));
  });
  const auto killed = pilot::run_program(arguments, "", 240.0);
  killer.join();
  ASSERT_TRUE(killed);
  ASSERT_EQ(SIGKILL, killed->signal) << killed->err;
}

}  // namespace granary::test
