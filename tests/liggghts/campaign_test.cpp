// Whole campaigns on real LIGGGHTS: small, but with every part a user meets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>

#include <atomic>
#include <cstdlib>
#include <map>
#include <thread>

#include "common/files.hpp"
#include "common/results/campaign_results.hpp"
#include "pilot/journal/journal.hpp"
#include "tests/support/granary_program.hpp"
#include "tests/support/killed_campaign.hpp"

namespace granary::test {
namespace {

/// The quick workflow, made smaller: few particles, short bursts, two rounds.
std::vector<std::string> small_campaign(const fs::path& dir) {
  return {"run",    (kSource / "workflows/quick.json").string(),
          "--dir",  dir.string(),
          "--json", "--quiet",
          "--set",  "/dem/particles=500",
          "--set",  "/dem/tally_window=\"10 ms\"",
          "--set",  "/process/residence_time=\"2 s\"",
          "--set",  "/dem/longest_burst=\"40 ms\"",
          "--set",  "/dem/settle=\"10 ms\"",
          "--set",  "/coupling/grace=\"10 ms\"",
          "--set",  "/coupling/steady_window=\"20 ms\"",
          "--set",  "/coupling/least_rounds=2",
          "--set",  "/coupling/most_rounds=2",
          "--set",  "/pbm/longest_burst=\"2 s\""};
}

std::vector<pilot::Record> journal_of(const fs::path& dir) {
  const auto content = pilot::read_journal(dir / "journal.jsonl");
  EXPECT_TRUE(content) << (content ? "" : content.error().message);
  return content ? content->records : std::vector<pilot::Record>{};
}

/// How often each burst's program ended.
std::map<std::string, int> times_finished(const fs::path& dir) {
  std::map<std::string, int> times;
  for (const pilot::Record& record : journal_of(dir)) {
    if (record.kind == "coupling.event" && record.payload.text_or("event", "") == "task_ended")
      ++times[std::to_string(record.payload.integer_or("round", 0)) + "-" + record.payload.text_or("kind", "?")];
  }
  return times;
}

TEST(Campaign, CouplesRealLiggghtsAndPbmBothWays) {
  const Scratch scratch;
  const auto summary = granary_json(small_campaign(scratch / "run"));

  EXPECT_THAT(summary.text_or("ended", ""), testing::AnyOf("limit", "steady"));
  EXPECT_EQ(2, summary.integer_or("dem_bursts", 0));
  EXPECT_EQ(2, summary.integer_or("pbm_bursts", 0));
  EXPECT_GT(summary.number_or("core_use", 0.0), 0.1);
  EXPECT_FALSE(fs::exists(scratch / "run/bursts/0001-dem/0001-dem.ranks")) << "one rank is started without mpirun";

  const auto results = read_results(summary.text_or("results", ""));
  ASSERT_TRUE(results) << results.error().message;
  for (const double drift : results->pbm.drift_solid_1) EXPECT_LT(drift, 1e-12);
  for (const double drift : results->pbm.drift_liquid) EXPECT_LT(drift, 1e-12);
  for (std::size_t t = 1; t < results->pbm.time.size(); ++t) EXPECT_GE(results->pbm.time[t], results->pbm.time[t - 1]);
  for (std::size_t w = 1; w < results->dem.time.size(); ++w) EXPECT_GT(results->dem.time[w], results->dem.time[w - 1]);
  ASSERT_EQ(2u, results->rates.size());
  EXPECT_GT(results->rates[0].collision_rate[0][0], 0.0);
  // The second DEM burst holds other sizes than the first: the coupling goes both ways.
  EXPECT_NE(results->rates[0].diameter, results->rates[1].diameter);

  const auto page = read_text(summary.text_or("report", ""));
  ASSERT_TRUE(page);
  EXPECT_THAT(*page, testing::HasSubstr("<svg"));
}

TEST(Campaign, GoesOnAfterAKillOfThePilotAndRunsNoFinishedBurstAgain) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  // As soon as the second round's DEM burst writes tallies: in the middle of a task.
  ASSERT_NO_FATAL_FAILURE(run_and_kill(small_campaign(dir), dir, "bursts/0002-dem/tallies.jsonl", 30.0));

  const auto summary = granary_json({"resume", dir.string(), "--json", "--quiet"});

  EXPECT_EQ(2, summary.integer_or("dem_bursts", 0));
  EXPECT_EQ(2, summary.integer_or("pbm_bursts", 0));
  const auto times = times_finished(dir);
  EXPECT_EQ(4u, times.size());
  for (const auto& [burst, n] : times) EXPECT_EQ(1, n) << burst;
  EXPECT_TRUE(fs::exists(dir / "bursts/0002-dem.attempt1/tallies.jsonl")) << "what the killed attempt wrote is kept";
}

TEST(Campaign, StopsGracefullyAndGoesOn) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  std::thread stopper([&] {
    for (int i = 0; i < 600 && !fs::exists(dir / "bursts/0002-dem/tallies.jsonl"); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_EQ(0, granary({"status", dir.string()}).exit_code);
    EXPECT_EQ(0, granary({"stop", dir.string()}).exit_code);
  });
  const auto stopped = granary(small_campaign(dir));
  stopper.join();
  ASSERT_EQ(4, stopped.exit_code) << stopped.err;
  EXPECT_THAT(granary({"status", dir.string()}).out, testing::HasSubstr("granary resume"));

  const auto summary = granary_json({"resume", dir.string(), "--json", "--quiet"});
  EXPECT_EQ(2, summary.integer_or("pbm_bursts", 0));
}

/// Processes of granary-monitor that work in a folder.
std::vector<pid_t> monitors_in(const fs::path& folder) {
  std::vector<pid_t> found;
  std::error_code gone;
  for (const auto& entry : fs::directory_iterator("/proc", gone)) {
    const pid_t pid = std::atoi(entry.path().filename().c_str());
    if (pid > 0 && fs::read_symlink(entry.path() / "exe", gone).filename() == "granary-monitor" &&
        fs::read_symlink(entry.path() / "cwd", gone) == folder)
      found.push_back(pid);
  }
  return found;
}

TEST(Campaign, RunsNoBurstAgainWhenItsMonitorIsKilledOrHangs) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  std::atomic<int> killed = 0, halted = 0;
  const auto signal_one = [&](const std::string& burst, int signal_number, std::atomic<int>& done) {
    for (int i = 0; i < 6000 && done == 0; ++i) {
      for (const pid_t pid : monitors_in(dir / "bursts" / burst))
        if (::kill(pid, signal_number) == 0) ++done;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  };
  std::thread killer([&] { signal_one("0001-dem", SIGKILL, killed); });
  std::thread halter([&] { signal_one("0002-dem", SIGSTOP, halted); });
  const auto summary = granary_json(small_campaign(dir));
  killer.join();
  halter.join();

  EXPECT_EQ(1, killed);
  EXPECT_EQ(1, halted);
  EXPECT_THAT(summary.text_or("ended", ""), testing::AnyOf("limit", "steady"));
  EXPECT_EQ(2, summary.integer_or("dem_bursts", 0));
  for (const auto& [burst, times] : times_finished(dir)) EXPECT_EQ(1, times) << burst;
}

TEST(Campaign, LosesNothingThatFinishedWhenTheDiskIsFull) {
  const Scratch scratch;
  const fs::path dir = scratch / "run";
  fs::create_directories(dir);
  if (::mount("none", dir.c_str(), "tmpfs", 0, "size=2m") != 0) GTEST_SKIP() << "may not mount a small file system";

  const auto full = granary(small_campaign(dir));
  EXPECT_THAT(full.exit_code, testing::AnyOf(3, 4)) << full.err;
  EXPECT_THAT(full.err, testing::AnyOf(testing::HasSubstr("space"), testing::HasSubstr("disk"))) << full.err;

  ASSERT_EQ(0, ::mount("none", dir.c_str(), "tmpfs", MS_REMOUNT, "size=50m"));
  const auto summary = granary_json({"resume", dir.string(), "--json", "--quiet"});
  EXPECT_EQ(2, summary.integer_or("dem_bursts", 0));
  EXPECT_EQ(2, summary.integer_or("pbm_bursts", 0));
  ::umount(dir.c_str());
}

TEST(Campaign, EndsWithTheCauseWhenTheDemDiverges) {
  const Scratch scratch;
  auto arguments = small_campaign(scratch / "run");
  arguments.insert(arguments.end(), {"--set", "/dem/guard/largest_overlap=1e-7"});
  const auto output = granary(arguments);
  EXPECT_EQ(3, output.exit_code);
  EXPECT_THAT(output.err, testing::HasSubstr("overlap"));
  EXPECT_THAT(output.err, testing::HasSubstr("/dem/"));
}

}  // namespace
}  // namespace granary::test
