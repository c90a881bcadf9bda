// The built programs, run as a user runs them.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "common/json/io.hpp"
#include "pilot/launch/run_program.hpp"

namespace granary::test {

namespace fs = std::filesystem;

inline const fs::path kSource = GRANARY_SOURCE_DIR;
inline const fs::path kPrograms = GRANARY_BIN_DIR;
inline const std::string kGranary = (kPrograms / "granary").string();

/// A fresh folder of this test's own, removed at its end if the test passed.
class Scratch {
 public:
  Scratch() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = fs::temp_directory_path() /
            ("granary_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" + std::to_string(::getpid()));
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    if (!::testing::Test::HasFailure()) fs::remove_all(path_, ignored);
  }
  fs::path operator/(const fs::path& name) const { return path_ / name; }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

inline pilot::ProgramOutput granary(std::vector<std::string> arguments, double timeout_s = 240.0) {
  arguments.insert(arguments.begin(), (kPrograms / "granary").string());
  auto output = pilot::run_program(arguments, "", timeout_s);
  EXPECT_TRUE(output) << (output ? "" : output.error().message);
  return output ? *output : pilot::ProgramOutput{};
}

/// stdout as the JSON document it must be.
inline json::Value granary_json(const std::vector<std::string>& arguments, double timeout_s = 240.0,
                                int exit_code = 0) {
  const auto output = granary(arguments, timeout_s);
  EXPECT_EQ(exit_code, output.exit_code) << output.err;
  auto value = json::parse(output.out, "stdout");
  EXPECT_TRUE(value) << output.out << output.err;
  return value ? *value : json::Value();
}

inline std::vector<fs::path> workflows() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kSource / "workflows"))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  return files;
}

}  // namespace granary::test
