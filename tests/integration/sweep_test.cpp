// Sweeps as a user runs them: to the end, killed in the middle and resumed, of a PBM and of a DEM.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <map>
#include <set>
#include <thread>

#include "common/files.hpp"
#include "common/json/io.hpp"
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
  std::vector<std::string> words{(kPrograms / "granary").string(),
                                 "run",
                                 (kSource / "workflows/breakage_study.json").string(),
                                 "--dir",
                                 dir.string(),
                                 "--json",
                                 "--quiet"};
  for (const char* set : {"/agglomerates/count=4", "/process/duration=0.06 s",
                          "/agglomerates/bonds/tensile_strength=2e3 Pa", "/dem/tally_window=0.01 s", "/dem/skin=0.5 mm",
                          "/sweep/grid/0/values=[\"300 rpm\"]", "/sweep/grid/1/values=[\"1000 rpm\", \"3000 rpm\"]"})
    words.insert(words.end(), {"--set", set});
  return words;
}

std::vector<json::Value> lines_of(const fs::path& file) {
  auto lines = json::read_lines(file);
  EXPECT_TRUE(lines.has_value()) << file;
  return lines.value_or(std::vector<json::Value>{});
}

/// Each sample later than the one before, each bond broken once, and as many as the last sample counts.
void expect_whole_history(const fs::path& folder) {
  const auto samples = lines_of(folder / "fragments.jsonl"), breaks = lines_of(folder / "breaks.jsonl");
  for (std::size_t k = 1; k < samples.size(); ++k)
    EXPECT_GT(samples[k]["step"].as_integer(), samples[k - 1]["step"].as_integer());
  std::set<std::string> bonds;
  for (const json::Value& one : breaks) EXPECT_TRUE(bonds.insert(json::dump(one["tags"])).second);
  EXPECT_EQ(samples.back()["broken"].as_integer(), static_cast<std::int64_t>(breaks.size()));
  double tallied = 0.0;
  for (const json::Value& window : lines_of(folder / "tallies.jsonl")) tallied += window.number_or("window_s", 0.0);
  const double header = lines_of(folder / "tallies.jsonl").front().number_or("window_s", 0.0);
  EXPECT_NEAR(tallied - header, samples.back().number_or("time_s", 0.0), 1e-9);
}

TEST(SweepOfADem, KilledInTheMiddleItGoesOnToTheSameFragments) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  {
    Background uncut(small_dem_sweep(scratch / "uncut"));
    EXPECT_EQ(0, uncut.exit_code());
  }
  {
    Background run(small_dem_sweep(dir));
    ASSERT_TRUE(wait_for(dir / "cases/0002/restart.liggghts", 120.0));
    run.signal(SIGKILL);
    run.exit_code();
  }
  const auto finished_first = read_text(dir / "cases/0001/fragments.jsonl").value();

  const auto output = granary({"resume", dir.string()});

  EXPECT_EQ(0, output.exit_code) << output.err;
  EXPECT_THAT(output.err, testing::HasSubstr("go on from their last state: 0002"));
  EXPECT_EQ(finished_first, read_text(dir / "cases/0001/fragments.jsonl").value());
  EXPECT_EQ(1, starts(dir)["case-0001.out"]);
  EXPECT_THAT(read_text(dir / "cases/0002/in.liggghts").value(), testing::HasSubstr("read_restart"));
  expect_whole_history(dir / "cases/0002");
  const fs::path cut = dir / "cases/0002", uncut = scratch / "uncut/cases/0002";
  const auto ours = lines_of(cut / "fragments.jsonl"), theirs = lines_of(uncut / "fragments.jsonl");
  ASSERT_EQ(ours.size(), theirs.size());
  EXPECT_GT(ours.back()["broken"].as_integer(), 20);
  for (std::size_t k = 0; k < ours.size(); ++k)
    for (const char* key : {"step", "broken", "sizes", "splits"}) EXPECT_TRUE(ours[k][key] == theirs[k][key]) << key;
  const auto broke = lines_of(cut / "breaks.jsonl"), should = lines_of(uncut / "breaks.jsonl");
  ASSERT_EQ(broke.size(), should.size());
  for (std::size_t k = 0; k < broke.size(); ++k) {
    EXPECT_TRUE(broke[k]["tags"] == should[k]["tags"]);
    EXPECT_TRUE(broke[k]["cause"] == should[k]["cause"]);
    EXPECT_NEAR(broke[k].number_or("stress_pa", 0.0), should[k].number_or("stress_pa", 1.0), 1.0);
  }
  const std::string table = read_text(dir / "sweep.csv").value();
  EXPECT_THAT(table, testing::HasSubstr("0001,300 rpm,1000 rpm,finished"));
  EXPECT_THAT(table, testing::HasSubstr("0002,300 rpm,3000 rpm,finished"));
  EXPECT_THAT(table, testing::HasSubstr("breakage_ratio"));

  // Weak bonds and the fall on the bottom: some broke, and a kernel can be made of it.
  const auto kernel = granary_json({"kernel", dir.string(), "--json", "--held-out", "0002"});
  EXPECT_EQ(2u, kernel["cases"].size());
  EXPECT_GT(kernel["cases"].items()[0].number_or("pbm_d50_m", 0.0), 1e-3);
  EXPECT_FALSE(kernel["cases"].items()[1]["fitted"].as_bool());
  EXPECT_TRUE(fs::exists(dir / "kernel/d50.svg"));
}

TEST(SweepOfADem, StoppedInTheMiddleItLosesAndDoublesNothing) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  {
    Background run(small_dem_sweep(dir));
    ASSERT_TRUE(wait_for(dir / "cases/0002/restart.liggghts", 120.0));
    EXPECT_EQ(0, granary({"stop", dir.string()}).exit_code);
    run.exit_code();
  }
  const auto before = lines_of(dir / "cases/0002/fragments.jsonl");

  const auto output = granary({"resume", dir.string()});

  EXPECT_EQ(0, output.exit_code) << output.err;
  EXPECT_THAT(output.err, testing::HasSubstr("go on from their last state: 0002"));
  expect_whole_history(dir / "cases/0002");
  const auto after = lines_of(dir / "cases/0002/fragments.jsonl");
  ASSERT_GT(after.size(), before.size());
  for (std::size_t k = 0; k < before.size(); ++k) EXPECT_TRUE(before[k] == after[k]);
  EXPECT_NEAR(after.back().number_or("time_s", 0.0), 0.06, 1e-3);
}

}  // namespace
}  // namespace granary::test
