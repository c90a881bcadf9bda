// granary run --dry-run and granary validate, as a user calls them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "tests/support/granary_program.hpp"

namespace granary::test {
namespace {

TEST(Validate, AcceptsEveryWorkflowWeShip) {
  std::vector<std::string> arguments{"validate"};
  for (const fs::path& file : workflows()) arguments.push_back(file.string());
  const auto output = granary(arguments);
  EXPECT_EQ(0, output.exit_code) << output.err;
  EXPECT_EQ(static_cast<long>(workflows().size()), std::count(output.out.begin(), output.out.end(), '\n'));
}

TEST(DryRun, BringsEveryWorkflowToItsEndInUnderASecond) {
  for (const fs::path& file : workflows()) {
    const auto begin = std::chrono::steady_clock::now();
    const auto summary = granary_json({"run", file.string(), "--dry-run", "--json", "--nodes", "4", "--cores", "64"});
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    EXPECT_NE("failed", summary.text_or("ended", "failed")) << file;
    EXPECT_EQ(256, summary.integer_or("cores", 0));
    EXPECT_LT(took.count(), 1.0) << file;
  }
}

TEST(DryRun, NeverGivesACoreToTwoTasksAtOnce) {
  for (const fs::path& file : workflows()) {
    const auto summary = granary_json({"run", file.string(), "--dry-run", "--json", "--cores", "16"});
    struct Stretch {
      double start, end;
    };
    std::map<std::int64_t, std::vector<Stretch>> by_core;
    for (const json::Value& entry : summary["timeline"].items_or_none())
      for (const json::Value& core : entry["cores"].items())
        by_core[core.as_integer()].push_back({entry.number_or("start_s", 0.0), entry.number_or("end_s", 0.0)});
    EXPECT_FALSE(by_core.empty()) << file;
    for (auto& [core, stretches] : by_core) {
      std::sort(stretches.begin(), stretches.end(),
                [](const Stretch& a, const Stretch& b) { return a.start < b.start; });
      for (std::size_t i = 1; i < stretches.size(); ++i)
        EXPECT_LE(stretches[i - 1].end, stretches[i].start + 1e-9) << file << " core " << core;
    }
  }
}

TEST(DryRun, FillsIdleCoresWithAnEstimationAndTakesNoLonger) {
  std::vector<std::string> arguments{"run",       (kSource / "workflows/cm5.json").string(),
                                     "--dry-run", "--json",
                                     "--cores",   "256",
                                     "--set",     "/dem/ranks=128",
                                     "--set",     "/pbm/ranks=8"};
  const auto without = granary_json(arguments);
  arguments.insert(
      arguments.end(),
      {"--set", R"(/estimation={"parameters": [{"name": "rate", "key": "/pbm/aggregation/rate", "from": 1e-4,
                               "to": 10}], "targets": [{"quantity": "d50", "at": "90 s", "value": "100 um",
                               "error": "5 %"}]})"});
  const auto with = granary_json(arguments);

  EXPECT_LT(without.number_or("core_use", 1.0), 0.6);
  EXPECT_GT(with.number_or("core_use", 0.0), 0.9);
  EXPECT_LE(with.number_or("wall_s", 1e9), 1.02 * without.number_or("wall_s", 0.0));
}

TEST(DryRun, NeedsNeitherLiggghtsNorMpiAndWritesNothing) {
  const Scratch scratch;
  // env -i: no PATH to find any program by.
  const auto output =
      pilot::run_program({"/usr/bin/env", "-i", "-C", scratch.path().string(), (kPrograms / "granary").string(), "run",
                          (kSource / "workflows/quick.json").string(), "--dry-run"},
                         "", 10.0);
  ASSERT_TRUE(output);
  EXPECT_EQ(0, output->exit_code) << output->err;
  EXPECT_THAT(output->out, testing::HasSubstr("0001-dem"));
  EXPECT_THAT(output->out, testing::HasSubstr("core use"));
  EXPECT_TRUE(fs::is_empty(scratch.path()));
}

TEST(DryRun, RefusesAMachineTooSmallForATask) {
  const auto output = granary({"run", (kSource / "workflows/cm5.json").string(), "--dry-run", "--cores", "1"});
  EXPECT_EQ(2, output.exit_code);
  EXPECT_THAT(output.err, testing::HasSubstr("core"));
}

TEST(Run, SaysEverythingThatIsWrongAtOnceAndMakesNoFolder) {
  const Scratch scratch;
  const auto output = granary({"run", (kSource / "workflows/quick.json").string(), "--dir", (scratch / "run").string(),
                               "--set", "/dem/time_step=\"5 kg\"", "--set", "/coupling/threshold=-1"});
  EXPECT_EQ(2, output.exit_code);
  EXPECT_THAT(output.err, testing::HasSubstr("/dem/time_step is \"5 kg\""));
  EXPECT_THAT(output.err, testing::HasSubstr("/coupling/threshold is -1"));
  EXPECT_FALSE(fs::exists(scratch / "run"));
}

TEST(Run, RefusesNodesOutsideADryRun) {
  const auto output = granary({"run", (kSource / "workflows/quick.json").string(), "--nodes", "4"});
  EXPECT_EQ(2, output.exit_code);
  EXPECT_THAT(output.err, testing::HasSubstr("--dry-run"));
}

TEST(Resume, SaysThatThereIsNothingToResume) {
  const Scratch scratch;
  const auto output = granary({"resume", scratch.path().string()});
  EXPECT_EQ(2, output.exit_code);
  EXPECT_THAT(output.err, testing::HasSubstr("no campaign is there"));
}

TEST(Tasks, RunAListToItsEnd) {
  const Scratch scratch;
  const auto summary =
      granary_json({"run", (kSource / "workflows/tasks.json").string(), "--dir", (scratch / "run").string(), "--json"});
  EXPECT_EQ(0, summary.integer_or("failed", -1));
  EXPECT_GT(summary.integer_or("finished", 0), 0);
}

}  // namespace
}  // namespace granary::test
