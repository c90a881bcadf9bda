// Sweeps as a user runs them: to the end, killed in the middle and resumed, of a PBM and of a DEM.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <map>
#include <thread>

#include "common/files.hpp"
#include "pilot/journal/journal.hpp"
#include "tests/support/background.hpp"
#include "tests/support/granary_program.hpp"

namespace granary::test {
namespace {

/// How often each case's program was started.
std::map<std::string, int> starts(const fs::path& dir) {
  std::map<std::string, int> times;
  for (const auto& entry : fs::recursive_directory_iterator(dir / "cases"))
    if (const std::string name = entry.path().filename().string(); name.starts_with("case-") && name.ends_with(".out"))
      ++times[name];
  return times;
}

/// Until the case has finished.
bool wait_for(const fs::path& file, double seconds) {
  for (int i = 0; i < static_cast<int>(100 * seconds); ++i) {
    if (fs::exists(file)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

TEST(SweepOfABalance, RunsEveryCaseAndTellsThemInOneTable) {
  const Scratch scratch;
  const auto summary =
      granary_json({"run", (kSource / "workflows/pbm_sweep.json").string(), "--dir", (scratch / "run").string(),
                    "--json", "--quiet", "--set", "/process/duration=20 s", "--set", "/spray/start=2 s"});

  EXPECT_EQ(12, summary.integer_or("finished", 0));
  const auto& cases = summary["cases"].items();
  ASSERT_EQ(12u, cases.size());
  // More aggregation, larger granules; more breakage, smaller ones.
  const auto d50 = [&](std::size_t i) { return cases[i]["figures"].number_or("outlet.d50_m", 0.0); };
  EXPECT_GT(d50(3), d50(0));
  EXPECT_LT(d50(8), d50(0));
  EXPECT_THAT(read_text(scratch / "run/sweep.csv").value(), testing::HasSubstr("0012,0.01 1/s,4 1/s,finished"));
  EXPECT_TRUE(fs::exists(scratch / "run/report.html"));
  EXPECT_TRUE(fs::exists(scratch / "run/results.h5"));
  EXPECT_EQ(0, granary({"report", (scratch / "run").string(), "--figures", (scratch / "figures").string()}).exit_code);
  EXPECT_TRUE(fs::exists(scratch / "figures/time-outlet-d50-m.svg"));
}

TEST(SweepOfABalance, DryRunsByTheCostModel) {
  const auto plan = granary_json({"run", (kSource / "workflows/pbm_sweep.json").string(), "--dry-run", "--json"});

  EXPECT_EQ("finished", plan.text_or("ended", ""));
  EXPECT_EQ(12u, plan["timeline"].size());
}

std::vector<std::string> small_dem_sweep(const fs::path& dir) {
  return {(kPrograms / "granary").string(),
          "run",
          (kSource / "workflows/breakage_study.json").string(),
          "--dir",
          dir.string(),
          "--json",
          "--quiet",
          "--set",
          "/agglomerates/count=4",
          "--set",
          "/process/duration=0.06 s",
          "--set",
          "/agglomerates/bonds/tensile_strength=2e3 Pa",
          "--set",
          "/sweep/grid/0/values=[\"300 rpm\"]",
          "--set",
          "/sweep/grid/1/values=[\"1000 rpm\", \"3000 rpm\"]"};
}

TEST(SweepOfADem, LosesNoFinishedCaseWhenItIsKilledAndStartsTheOtherAnew) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  {
    Background run(small_dem_sweep(dir));
    ASSERT_TRUE(wait_for(dir / "cases/0002/fragments.jsonl", 120.0));
    run.signal(SIGKILL);
    run.exit_code();
  }
  const auto finished_first = read_text(dir / "cases/0001/fragments.jsonl").value();

  const auto output = granary({"resume", dir.string()});

  EXPECT_EQ(0, output.exit_code) << output.err;
  EXPECT_THAT(output.err, testing::HasSubstr("start anew: 0002"));
  EXPECT_TRUE(fs::exists(dir / "cases/0002.cut1/fragments.jsonl"));
  EXPECT_EQ(finished_first, read_text(dir / "cases/0001/fragments.jsonl").value());
  EXPECT_EQ(1, starts(dir)["case-0001.out"]);
  EXPECT_EQ(2, starts(dir)["case-0002.out"]);
  const std::string table = read_text(dir / "sweep.csv").value();
  EXPECT_THAT(table, testing::HasSubstr("0001,300 rpm,1000 rpm,finished"));
  EXPECT_THAT(table, testing::HasSubstr("0002,300 rpm,3000 rpm,finished"));
  EXPECT_THAT(table, testing::HasSubstr("breakage_ratio"));
  EXPECT_THAT(read_text(dir / "cases/0001/in.liggghts").value(), testing::HasSubstr("granary/bond"));

  // Weak bonds and the fall on the bottom: some broke, and a kernel can be made of it.
  const auto kernel = granary_json({"kernel", dir.string(), "--json", "--held-out", "0002"});
  EXPECT_EQ(2u, kernel["cases"].size());
  EXPECT_GT(kernel["cases"].items()[0].number_or("pbm_d50_m", 0.0), 1e-3);
  EXPECT_FALSE(kernel["cases"].items()[1]["fitted"].as_bool());
  EXPECT_TRUE(fs::exists(dir / "kernel/d50.svg"));
}

}  // namespace
}  // namespace granary::test
