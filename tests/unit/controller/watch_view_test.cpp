// What the watcher makes of a run directory, and what the drawings make of its view.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "controller/watch/plain_lines.hpp"
#include "controller/watch/screen.hpp"
#include "controller/watch/text_chart.hpp"
#include "controller/watch/time_left.hpp"
#include "controller/watch/watcher.hpp"
#include "controller/watch/words.hpp"
#include "tests/support/granary_program.hpp"
#include "tests/support/recorded_campaign.hpp"

namespace granary::watch {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Watch : public ::testing::Test {
 protected:
  test::Scratch scratch;
  test::RecordedCampaign campaign{scratch / "run"};
  json::Value status = json::Value::object({{"alive", false}, {"counts", json::Value::object()}});
  json::Value queue = json::Value::array();
  double clock = 0.0;
  int times_asked = 0;
  Watcher watcher{campaign.dir(),
                  {[this]() -> Result<json::Value> {
                     ++times_asked;
                     return status;
                   },
                   [this] { return queue; }, [this] { return clock; }}};

  void alive(double time) {
    status = json::Value::object({{"alive", true},
                                  {"time_s", time},
                                  {"cores", 2},
                                  {"busy_cores", 2},
                                  {"counts", json::Value::object({{"finished", 3}, {"running", 2}})}});
    json::Value cores = json::Value::array();
    cores.push(0).push(1);
    json::Value tasks = json::Value::array();
    tasks.push(json::Value::object({{"name", "0002-dem"}, {"state", "running"}, {"cores", cores}, {"seconds", 1.5}}));
    tasks.push(json::Value::object({{"name", "0002-dem-monitor"}, {"state", "running"}}));
    status.set("tasks", tasks);
  }
  static std::string text_of(const View& view, ScreenSize size = {100, 40}) {
    std::string text;
    for (const Row& row : screen(view, size, true)) text += printed(row, size.columns, false) + "\n";
    return text;
  }
};

std::vector<std::string> words(const View& view) {
  std::vector<std::string> all;
  for (const Happening& one : view.happenings) all.push_back(one.words);
  return all;
}

TEST_F(Watch, WaitsBeforeThePilotIsUpAndSaysWhatTheQueueSays) {
  campaign.coupled();
  EXPECT_TRUE(watcher.anything_there());

  EXPECT_EQ(Phase::waiting, watcher.look().phase);

  queue.push(json::Value::object({{"job", "17"}, {"state", "PENDING"}, {"reason", "Resources"}}));
  EXPECT_EQ("No pilot has begun yet", watcher.look().headline) << "the queue is not asked every time";
  clock = 20.0;
  EXPECT_EQ("Job 17 waits in Slurm's queue: PENDING (Resources)", watcher.look().headline);
}

TEST_F(Watch, ShowsTheBurstThatRunsWithItsClockAndWhoIsOnWhichCore) {
  campaign.coupled();
  campaign.open();
  campaign.round(1);
  campaign.start_burst(4.0, "0002-dem", 0.25, 0.2);
  campaign.tallies("0002-dem", {0.35});
  alive(5.5);

  const View view = watcher.look();

  EXPECT_EQ(Phase::running, view.phase);
  EXPECT_EQ("DEM burst 2 runs", view.headline);
  ASSERT_TRUE(view.burst);
  EXPECT_DOUBLE_EQ(0.35, view.burst_time);
  EXPECT_DOUBLE_EQ(0.25, view.burst->longest) << "with the settling";
  EXPECT_DOUBLE_EQ(2.0, view.process_time);
  EXPECT_THAT(view.busy_by_kind, ElementsAre(std::pair<std::string, int>{"dem", 2})) << "a monitor occupies no core";
  ASSERT_EQ(2U, view.bursts.size());
  EXPECT_EQ("drifted", view.bursts.back().reason);
  EXPECT_THAT(view.counts, ElementsAre(std::pair<std::string, std::int64_t>{"running", 2},
                                       std::pair<std::string, std::int64_t>{"ended", 3}));
}

TEST_F(Watch, CountsContactsAsTheExchangeDoes) {
  campaign.coupled();
  campaign.open();
  campaign.round(1);

  const View view = watcher.look();

  ASSERT_EQ(2U, view.contacts.size());
  EXPECT_DOUBLE_EQ(900.0, view.contacts[0].particles);
  EXPECT_DOUBLE_EQ(2.0 * 450.0 / (900.0 * 0.01), view.contacts[0].collisions) << "a pair once, two particles take part";
  EXPECT_DOUBLE_EQ(90.0 / (900.0 * 0.01), view.contacts[0].impacts);
}

TEST_F(Watch, LeavesOutWhatAPbmDidBeyondWhereTheDemTookOver) {
  campaign.coupled();
  campaign.open();
  campaign.round(1);
  campaign.round(2);

  const View view = watcher.look();

  std::vector<double> times;
  for (const SizePoint& point : view.sizes) times.push_back(point.time);
  EXPECT_THAT(times, ElementsAre(0.0, 1.0, 2.0, 2.0, 3.0, 4.0));
  EXPECT_DOUBLE_EQ(6.8e-5, view.sizes.back().d50[1]);
}

TEST_F(Watch, ReadsOnlyWhatIsNewAndForgetsAJournalWrittenAnew) {
  campaign.coupled();
  campaign.open();
  campaign.round(1);
  const auto before = watcher.look().journal_records;
  EXPECT_EQ(before, watcher.look().journal_records);

  campaign.append("journal.jsonl", R"({"n":99,"wall_s":1)");  // being written
  EXPECT_EQ(before, watcher.look().journal_records);

  std::filesystem::remove(campaign.dir() / "journal.jsonl");
  test::RecordedCampaign again(campaign.dir());
  again.open();
  const View view = watcher.look();
  EXPECT_EQ(1U, view.journal_records);
  EXPECT_THAT(view.bursts, IsEmpty());
}

TEST_F(Watch, TellsOfADamagedLineOnlyIfGoodOnesFollow) {
  campaign.tasks();
  campaign.open();
  campaign.append("journal.jsonl", "{\"n\":2,\"garbage\"}\n");
  EXPECT_THAT(watcher.look().warnings, Not(Contains(HasSubstr("checksum")))) << "a torn tail";

  campaign.close(1.0);

  EXPECT_THAT(watcher.look().warnings, Contains(HasSubstr("1 line of wrong checksum")));
}

TEST_F(Watch, EndsWithTheCampaignsExitCode) {
  campaign.coupled();
  campaign.open();
  campaign.round(1);
  campaign.end(4.0, "steady", "nothing moved");
  alive(4.2);
  EXPECT_EQ(Phase::finishing, watcher.look().phase) << "results and report come last";

  campaign.close(5.0);
  status = json::Value::object({{"alive", false}});
  const View view = watcher.look();
  EXPECT_EQ(Phase::ended, view.phase);
  EXPECT_EQ(Exit::ok, view.exit);
  EXPECT_THAT(view.headline, HasSubstr("steady: nothing moved"));
}

TEST_F(Watch, CallsAFailedCampaignFailedAndAKilledOneResumable) {
  campaign.coupled();
  campaign.open();
  campaign.round(1);
  View view = watcher.look();
  EXPECT_EQ(Exit::stopped, view.exit) << "the pilot is gone and nothing was decided";
  EXPECT_THAT(view.warnings, Contains(HasSubstr("was killed")));
  EXPECT_THAT(view.headline, HasSubstr("granary resume"));

  campaign.end(4.5, "failed", "0002-dem diverged");
  campaign.close(4.6);
  view = watcher.look();
  EXPECT_EQ(Exit::task_failed, view.exit);
  EXPECT_THAT(words(view), Contains(HasSubstr("failed: 0002-dem diverged")));
}

TEST_F(Watch, WaitsForTheNextJobOfAChain) {
  campaign.coupled();
  campaign.open();
  campaign.end(4.0, "stopped", "the job's time is nearly over");
  campaign.close(4.1);
  queue.push(json::Value::object({{"job", "18"}, {"state", "PENDING"}, {"reason", "Dependency"}}));

  EXPECT_EQ(Phase::waiting, watcher.look().phase);

  queue = json::Value::array();
  clock = 60.0;
  EXPECT_EQ(Exit::stopped, watcher.look().exit);
}

TEST_F(Watch, UsesOfCoresAreWhatTheJournalSays) {
  campaign.tasks();
  campaign.open(0.0, 4);
  campaign.submit(0, R"({"name":"a","command":["x"]})");
  campaign.submit(1, R"({"name":"b","command":["x"],"fill":true})");
  campaign.place(0.0, 0, "0-1");
  campaign.place(0.0, 1, "2");
  campaign.exit(6.0, 0, 0);
  campaign.record("task.suspend", 2.0, R"({"time_s":7.0,"id":1,"attempt":1})");
  campaign.record("task.resume", 2.0, R"({"time_s":9.0,"id":1,"attempt":1,"cores":[3]})");
  campaign.exit(10.0, 1, 0);
  campaign.close(10.0);
  status.set("counts", json::Value::object({{"finished", 2}}));

  const View view = watcher.look();

  EXPECT_NEAR((2.0 * 6.0 + 7.0 + 1.0) / 40.0, view.core_use, 1e-12);
  EXPECT_NEAR(8.0 / 40.0, view.core_use_fillers, 1e-12);
  EXPECT_EQ(1, view.fillers_done);
  EXPECT_EQ(Exit::ok, view.exit);
}

TEST_F(Watch, CountsTheCoresOfTasksOfACompactedJournal) {
  campaign.tasks();
  campaign.open(0.0, 2);
  campaign.record(
      "task.past", 10.0,
      R"({"id":0,"state":"finished","task":{"name":"a"},"attempts":[{"pieces":[[1.0,4.0,"0-1"],[5.0,6.0,"1"]]}]})");
  campaign.close(10.0);

  EXPECT_NEAR((2.0 * 3.0 + 1.0) / 20.0, watcher.look().core_use, 1e-12);
}

TEST_F(Watch, AFailedTaskIsAWarningAndAMonitorsVerdictIsNone) {
  campaign.tasks();
  campaign.open();
  campaign.submit(0, R"({"name":"bad","command":["x"]})");
  campaign.submit(1, R"({"name":"0001-dem-monitor","command":["x"]})");
  campaign.place(0.0, 0, "0");
  campaign.place(0.0, 1, "");
  campaign.exit(1.0, 0, 7);
  campaign.exit(1.0, 1, 10);
  campaign.close(1.0);
  status.set("counts", json::Value::object({{"failed", 1}, {"finished", 1}}));

  const View view = watcher.look();

  EXPECT_THAT(words(view), Contains("bad failed with exit code 7"));
  EXPECT_THAT(words(view), Not(Contains(HasSubstr("monitor"))));
  EXPECT_EQ(Exit::task_failed, view.exit);
}

TEST_F(Watch, AsksAStatusOfTheDeadOnlyOnceAJournal) {
  campaign.tasks();
  campaign.open();
  campaign.close(1.0);
  for (int k = 0; k < 5; ++k) (void)watcher.look();
  EXPECT_EQ(1, times_asked);

  campaign.open(1.0);
  (void)watcher.look();
  EXPECT_EQ(2, times_asked);
}

TEST_F(Watch, ToleratesAStatusWithoutAnyMember) {
  campaign.coupled();
  campaign.open();
  status = json::Value::object({{"alive", true}});

  const View view = watcher.look();

  EXPECT_EQ(Phase::running, view.phase);
  EXPECT_THAT(text_of(view), HasSubstr("mixer  running"));
}

// --- time left ---

TEST(TimeLeft, OfACoupledCampaignCountsWholeRoundsBothWays) {
  View view;
  view.mode = "two-way";
  view.process_time = 4.0;
  view.process_end = 60.0;
  view.steadiness = Steadiness{0.4, 0.4, 2, 3, 50, 0.05, "", "", kUnknown, 0.0, true, false};
  for (int n = 0; n < 2; ++n) {
    Burst dem, pbm;
    dem.dem = true;
    dem.pilot_start = 10.0 * n;
    dem.pilot_end = dem.end = 10.0 * n + 8.0;
    pbm.start = 2.0 * n;
    pbm.end = 2.0 * n + 2.0;
    pbm.pilot_start = dem.pilot_end;
    pbm.pilot_end = 10.0 * n + 10.0;
    view.bursts.insert(view.bursts.end(), {dem, pbm});
  }

  const auto left = time_left_coupled(view, 0.2, 23.0);

  ASSERT_TRUE(left);
  EXPECT_DOUBLE_EQ(1 * 10.0 - 3.0, left->least) << "one more round, 3 s of which are over";
  EXPECT_DOUBLE_EQ(28 * 10.0 - 3.0, left->most) << "56 s of process time at 2 s a round";
  EXPECT_THAT(left->how, HasSubstr("10.0 s a round"));

  view.steadiness->quiet_time = 0.0;
  EXPECT_DOUBLE_EQ(2 * 10.0 - 3.0, time_left_coupled(view, 0.2, 23.0)->least) << "the DEM needs two bursts to be quiet";
  view.bursts.clear();
  EXPECT_FALSE(time_left_coupled(view, 0.2, 3.0)) << "no round is over";
}

TEST(TimeLeft, OfALoneProcessFollowsItsOwnPace) {
  View view;
  view.mode = "pbm-only";
  view.process_end = 100.0;
  view.burst = Burst{};
  view.burst->pilot_start = 2.0;
  view.burst_time = 25.0;

  EXPECT_DOUBLE_EQ(30.0, time_left_coupled(view, 0.0, 12.0)->most);
}

TEST(TimeLeft, OfTasksNeedsAFewEnds) {
  EXPECT_FALSE(time_left_tasks(2, 10, 5.0));
  EXPECT_DOUBLE_EQ(20.0, time_left_tasks(5, 10, 10.0)->most);
}

// --- drawings ---

TEST_F(Watch, ScreenFitsAnySizeAndShowsWhatMattersOnASmallOne) {
  campaign.coupled();
  campaign.open();
  campaign.round(1);
  campaign.round(2);
  campaign.start_burst(
      8.0, "0003-dem", 0.5, 0.2,
      R"({"steady_time_s":0.4,"largest_change":{"what":"d50_m","where":"compartment 2","change":-0.12}})");
  alive(9.0);
  const View view = watcher.look();

  for (const ScreenSize size : {ScreenSize{20, 3}, {40, 10}, {80, 24}, {80, 50}, {200, 60}}) {
    const auto rows = screen(view, size, true);
    EXPECT_LE(static_cast<int>(rows.size()), size.rows);
    for (const Row& row : rows) EXPECT_LE(width_of(printed(row, size.columns, false)), size.columns);
  }
  const std::string small = text_of(view, {80, 24});
  for (const char* shown :
       {"mixer  running", "DEM burst 3 runs", "quiet 0.4/0.4 s", "differ 12/5 %: d50, compartment 2", "2 of 2 busy",
        "0002-dem-monitor", "um at the outlet", "DEM 3     [", "PBM burst 2 gives d50 70 to 90 um"})
    EXPECT_THAT(small, HasSubstr(shown));
}

TEST_F(Watch, ColoursOnlyOnRequestAndNeverPassesOrdersToTheTerminal) {
  campaign.tasks();
  campaign.open();
  View view = watcher.look();
  view.warnings = {"evil \033[2J\a name"};

  for (const Row& row : screen(view, {80, 24}, true)) {
    EXPECT_THAT(printed(row, 80, false), Not(HasSubstr("\033")));
    EXPECT_THAT(printed(row, 80, true), AllOf(Not(HasSubstr("\033[2J")), Not(HasSubstr("\a"))));
  }
  EXPECT_THAT(printed(screen(view, {80, 24}, true)[2], 80, true), HasSubstr("\033[1;38;5;160m! evil ?[2J? name"));
}

TEST_F(Watch, PlainLinesTellEachHappeningOnceAndTheEndLast) {
  campaign.coupled();
  campaign.open();
  campaign.round(1);
  alive(4.0);
  PlainLines plain;
  const auto first = plain.lines(watcher.look(), 0.0);
  EXPECT_THAT(first, Contains(HasSubstr("DEM burst 1 gives 100 collisions and 3 impacts per particle and second")));

  EXPECT_THAT(plain.lines(watcher.look(), 0.5), IsEmpty());
  EXPECT_THAT(plain.lines(watcher.look(), 11.0), ElementsAre(HasSubstr("2 of 2 cores busy")))
      << "how it stands, now and then";

  campaign.end(4.5, "limit", "the process ended");
  campaign.close(4.6);
  status = json::Value::object({{"alive", false}});
  const auto last = plain.lines(watcher.look(), 12.0);
  EXPECT_THAT(last.back(), HasSubstr("exit code 0"));
  EXPECT_THAT(last, Not(Contains(HasSubstr("gives 100 collisions"))));
}

TEST_F(Watch, PlainLinesCountEndsOfManyTasksInsteadOfTellingEach) {
  campaign.tasks();
  campaign.open();
  PlainLines plain;
  alive(0.0);
  (void)plain.lines(watcher.look(), 0.0);
  for (int id = 0; id < 20; ++id) {
    campaign.submit(id, R"({"name":"t","command":["x"]})");
    campaign.place(1.0, id, "0");
    campaign.exit(1.0, id, 0);
  }

  EXPECT_EQ(1U, plain.lines(watcher.look(), 1.0).size());
}

TEST(TextChart, ResamplesByMeansAndHoldsTheLastValue) {
  EXPECT_THAT(resampled({0.0, 1.0, 2.0, 8.0}, {1.0, 3.0, 5.0, 9.0}, 4), ElementsAre(2.0, 5.0, 5.0, 9.0));
  EXPECT_THAT(resampled({2.0}, {5.0}, 2), ElementsAre(5.0, 5.0));
}

TEST(TextChart, AreasReachFromFootToTop) {
  EXPECT_THAT(area({0.0, 0.5, 1.0}, 0.0, 1.0, 2, true), ElementsAre("  █", "▁██"));
  EXPECT_THAT(area({0.0, kUnknown, 1.0}, 0.0, 1.0, 1, false), ElementsAre(". #"));
}

TEST(CoreSeconds, KeepTheirSumHoweverOftenTheSlicesDouble) {
  CoreSeconds seconds;
  double total = 0.0;
  for (int k = 0; k < 5000; ++k, total += 2.0 * 0.9) seconds.add("dem", k, k + 0.9, 2);

  const CoreHistory history = seconds.history(5000.0);

  ASSERT_EQ(1U, history.busy.size());
  EXPECT_LE(history.busy[0].second.size(), 480U);
  double sum = 0.0;
  for (std::size_t k = 0; k < history.busy[0].second.size(); ++k)
    sum += history.busy[0].second[k] * std::min(history.slice, 5000.0 - history.slice * static_cast<double>(k));
  EXPECT_NEAR(total, sum, 1e-6);
}

TEST(Words, AreThoseAPersonUses) {
  EXPECT_EQ("12.4 s", duration(12.4));
  EXPECT_EQ("1 min 12 s", duration(72.0));
  EXPECT_EQ("2 h 05 min", duration(7500.0));
  EXPECT_EQ("3 d 04 h", duration(76.0 * 3600));
  EXPECT_EQ("about 20.0 s left", left_words(20.0, 20.0));
  EXPECT_EQ("at most 4 min 37 s left", left_words(0.0, 277.0));
  EXPECT_EQ("7.0 s to 4 min 37 s left", left_words(7.0, 277.0));
  EXPECT_EQ("DEM burst 3", burst_words("0003-dem"));
  EXPECT_EQ("PBM burst 120", burst_words("0120-pbm"));
  EXPECT_EQ("own-name", burst_words("own-name"));
}

TEST_F(Watch, JsonThinsLongSeriesAndKeepsTheirEnds) {
  View view;
  for (int k = 0; k < 5000; ++k) view.sizes.push_back({0.1 * k, {1e-5}, {1.0}});

  const json::Value value = to_json(view, 100);

  const auto time = value["sizes"].numbers("time_s");
  ASSERT_EQ(100U, time.size());
  EXPECT_DOUBLE_EQ(0.0, time.front());
  EXPECT_DOUBLE_EQ(499.9, time.back());
}

}  // namespace
}  // namespace granary::watch
