// granary estimate with the real programs: what was hidden is found, and stops and kills lose nothing that was known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <thread>

#include "tests/support/background.hpp"
#include "tests/support/granary_program.hpp"

namespace granary {
namespace {

using json::Value;
using test::Background;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kTwin = (test::kSource / "workflows" / "estimate_twin.json").string();

class Estimate : public ::testing::Test {
 protected:
  test::Scratch scratch;
  std::string dir = (scratch / "run").string();

  std::vector<Value> log() const {
    auto lines = json::LineReader(dir + "/estimation/evaluations.jsonl").next();
    return lines ? *lines : std::vector<Value>{};
  }
  /// Numbers of all trials in the log; each must be there once.
  std::set<std::int64_t> trials() const {
    std::set<std::int64_t> numbers;
    for (const Value& line : log()) {
      if (line.find("trial") == nullptr) continue;
      EXPECT_TRUE(numbers.insert(line["trial"].as_integer()).second);
    }
    return numbers;
  }
  bool waits_for(std::size_t n_trials) const {
    for (int k = 0; k < 1200 && trials().size() < n_trials; ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return trials().size() >= n_trials;
  }
};

/// What docs/estimation.md says was hidden.
constexpr struct {
  const char* name;
  double value;
} kHidden[] = {{"aggregation rate", 8.0}, {"breakage rate", 0.3}, {"consolidation rate", 0.03}};

void expect_found(const Value& report) {
  ASSERT_EQ(report["parameters"].size(), std::size(kHidden));
  for (std::size_t k = 0; k < std::size(kHidden); ++k) {
    const Value& p = report["parameters"].items()[k];
    EXPECT_EQ(p["name"].as_string(), kHidden[k].name);
    EXPECT_LT(p["low"].as_number(), kHidden[k].value) << kHidden[k].name;
    EXPECT_GT(p["high"].as_number(), kHidden[k].value) << kHidden[k].name;
    EXPECT_LT(p["high"].as_number() / p["low"].as_number(), 8.0) << kHidden[k].name << ", of bounds 1000 apart";
  }
  EXPECT_EQ(report["phase"].as_string(), "done");
  EXPECT_TRUE(report["unidentified"].items().empty());
  EXPECT_LT(report["held_out_mean_square"].as_number(), 4.0);
}

TEST_F(Estimate, FindsWhatWasHiddenAfterAStopAndAKill) {
  {
    Background first({test::kGranary, "estimate", kTwin, "--dir", dir, "--cores", "2", "--quiet", "--set",
                      "/estimation/most_evaluations=400", "--set", "/outputs/report=false"});
    ASSERT_TRUE(waits_for(30));
    first.signal(SIGINT);
    EXPECT_EQ(4, first.exit_code());
  }
  const auto before = trials();
  EXPECT_THAT(test::granary({"status", dir}).out, HasSubstr("granary resume"));
  {
    Background second({test::kGranary, "resume", dir, "--quiet"});
    ASSERT_TRUE(waits_for(before.size() + 60));
    second.signal(SIGKILL);
    EXPECT_EQ(128 + SIGKILL, second.exit_code());
  }
  const Value report = test::granary_json({"resume", dir, "--json", "--quiet"});

  expect_found(report);
  EXPECT_EQ(static_cast<std::int64_t>(trials().size()),
            report["evaluated"].as_integer() + report["failed"].as_integer());
  EXPECT_EQ(report["failed"].as_integer(), 0);
  // Once more: there is nothing left to do.
  const auto again = test::granary({"resume", dir, "--quiet"});
  EXPECT_EQ(0, again.exit_code);
  EXPECT_THAT(again.out, HasSubstr("aggregation rate"));
  EXPECT_THAT(test::granary({"status", dir}).out, Not(HasSubstr("granary resume")));
}

TEST_F(Estimate, RefusesAWorkflowThatFitsNothingBeforeItMakesAFolder) {
  const auto refused =
      test::granary({"estimate", (test::kSource / "workflows" / "pbm_only.json").string(), "--dir", dir});
  EXPECT_EQ(2, refused.exit_code);
  EXPECT_THAT(refused.err, HasSubstr("estimation"));
  EXPECT_FALSE(std::filesystem::exists(dir));
}

TEST_F(Estimate, SaysWhatIsWrongWithAProblemOfItsOwnAtOnce) {
  const auto problem = (scratch / "problem.json").string(), trials = (scratch / "trials.json").string();
  const auto evaluate = [&] {
    return *pilot::run_program({(test::kPrograms / "granary-pbm").string(), "evaluate", problem, trials, "--out",
                                (scratch / "out.jsonl").string()},
                               "", 20.0);
  };
  std::ofstream(problem) << R"({"format": "granary-estimation-1",
    "parameters": [{"name": "a", "pointer": "/aggregation/rate", "low": 1, "high": 2}],
    "experiments": [{"name": "one", "segments": [{"aggregation": {"rate": 1}, "bins": 3}]}],
    "targets": [{"experiment": "one", "quantity": "d50", "time": 1, "value": 1e-4, "error": 1e-5}]})";
  std::ofstream(trials) << R"({"trials": [{"number": 1, "values": [1, 2]}]})";
  const auto refused = evaluate();
  EXPECT_EQ(2, refused.exit_code);
  EXPECT_THAT(refused.err, HasSubstr("experiment \"one\", segment 0"));
  EXPECT_THAT(refused.err, HasSubstr("/bins"));
}

}  // namespace
}  // namespace granary
