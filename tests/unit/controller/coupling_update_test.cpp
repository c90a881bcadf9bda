#include "controller/coupling/update.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <random>
#include <set>

#include "common/json/io.hpp"

namespace granary::coupling {
namespace {

using monitor::Outcome;
using ::testing::HasSubstr;

constexpr BurstId dem(int round) { return {round, Kind::dem}; }
constexpr BurstId pbm(int round) { return {round, Kind::pbm}; }

monitor::Verdict a_verdict(Outcome outcome, double time) {
  monitor::Verdict verdict;
  verdict.outcome = outcome;
  verdict.time = time;
  verdict.watched = "d50_m";
  verdict.where = "compartment 2";
  verdict.change = 0.17;
  verdict.message = "d50_m in compartment 2 moved by +17 %";
  return verdict;
}

DemSummary a_dem(double start, double end, double collision_frequency = 50.0) {
  return {start, end, 40.0, 2000.0, collision_frequency, 20.0, 1e6, 1e5, {5e-5, 1e-4}, {2.0, 1.5}, {0.01, 0.02}};
}
PbmSummary a_pbm(double time, double d50 = 1e-4) { return {time, {d50, 1.2 * d50}, {1e9, 8e8}}; }

/// Drives the state machine and remembers what it asked for last.
class Campaign {
 public:
  explicit Campaign(Settings s = {}) : settings(s) {}

  Campaign& tell(const Event& event) {
    journal.push_back(event);
    Step step = update(state, event, settings);
    state = std::move(step.next);
    asked = std::move(step.actions);
    return *this;
  }

  template <class A>
  const A& only() const {
    static const A none{};
    if (asked.size() != 1 || !std::holds_alternative<A>(asked[0])) {
      ADD_FAILURE() << "asked for " << asked.size() << " actions"
                    << (asked.empty() ? "" : ": " + json::dump(to_json(asked[0])));
      return none;
    }
    return std::get<A>(asked[0]);
  }

  /// The burst ends because its monitor says so.
  Campaign& ends_by(BurstId burst, Outcome outcome, double verdict_time, double program_time) {
    tell(MonitorSpoke{burst, state.attempt, a_verdict(outcome, verdict_time)});
    return tell(TaskEnded{burst, state.attempt, TaskEnded::Outcome::stopped, program_time, ""});
  }
  /// The program ends by itself, and its monitor has nothing to say.
  Campaign& ends_alone(BurstId burst, double time) {
    tell(TaskEnded{burst, state.attempt, TaskEnded::Outcome::finished, time, ""});
    return tell(MonitorSpoke{burst, state.attempt, a_verdict(Outcome::ended, time)});
  }
  /// A whole round of bursts that run their full time; process time goes on by ten seconds, DEM time by three.
  Campaign& round(int n, double collision_frequency = 50.0, double d50 = 1e-4) {
    ends_alone(dem(n), 3.0 * n);
    tell(DemExchanged{dem(n), state.attempt, a_dem(3.0 * n - 3.0, 3.0 * n, collision_frequency)});
    ends_alone(pbm(n), 10.0 * n);
    return tell(PbmExchanged{pbm(n), state.attempt, a_pbm(10.0 * n, d50)});
  }

  Settings settings;
  State state;
  std::vector<Action> asked;
  std::vector<Event> journal;
};

Settings settings() {
  Settings s;
  s.steady_window = 5.0;
  s.longest_dem_burst = 3.0;
  s.longest_pbm_burst = 10.0;
  s.process_duration = 100.0;
  return s;
}

TEST(Coupling, BeginsWithTheDem) {
  Campaign campaign(settings());
  const auto& start = campaign.tell(Began{}).only<StartBurst>();

  EXPECT_EQ(dem(1), start.burst);
  EXPECT_EQ(1, start.attempt);
  EXPECT_EQ(0.0, start.start_time);
  EXPECT_EQ(3.0, start.longest);
  EXPECT_FALSE(start.restart) << "there is nothing to go on from";
  EXPECT_FALSE(start.takes_from);
}

TEST(Coupling, StopsADriftingDemAndHandsItsRatesToThePbm) {
  Campaign campaign(settings());
  campaign.tell(Began{}).tell(MonitorSpoke{dem(1), 1, a_verdict(Outcome::drifted, 0.6)});
  EXPECT_EQ("drifted", campaign.only<StopTask>().why.reason);
  EXPECT_EQ(0.17, campaign.only<StopTask>().why.numbers["change"].as_number()) << "the journal shall have the numbers";

  campaign.tell(TaskEnded{dem(1), 1, TaskEnded::Outcome::stopped, 0.65, ""});
  EXPECT_EQ(dem(1), campaign.only<Exchange>().burst);
  EXPECT_EQ(0.65, campaign.only<Exchange>().time) << "a DEM can not go back: its end is where it stopped";

  campaign.tell(DemExchanged{dem(1), 1, a_dem(0.0, 0.65)});
  const auto& start = campaign.only<StartBurst>();
  EXPECT_EQ(pbm(1), start.burst);
  EXPECT_EQ(dem(1), start.takes_from);
  EXPECT_FALSE(start.restart);
  EXPECT_EQ(10.0, start.longest);
}

TEST(Coupling, TakesThePbmBackToWhereItsDriftWasSeen) {
  Campaign campaign(settings());
  campaign.tell(Began{}).ends_alone(dem(1), 3.0).tell(DemExchanged{dem(1), 1, a_dem(0.0, 3.0)});

  campaign.ends_by(pbm(1), Outcome::drifted, 8.4, 9.8);
  EXPECT_EQ(8.4, campaign.only<Exchange>().time) << "not 9.8 s, where the program was stopped";

  campaign.tell(PbmExchanged{pbm(1), 1, a_pbm(8.4)});
  EXPECT_EQ(dem(2), campaign.only<StartBurst>().burst);
  EXPECT_EQ(8.4, campaign.state.process_clock);
}

TEST(Coupling, LetsEachSideGoOnFromItsOwnLastStateAndTheOthersResult) {
  Campaign campaign(settings());
  campaign.tell(Began{}).ends_alone(dem(1), 3.0).tell(DemExchanged{dem(1), 1, a_dem(0.0, 3.0)});
  campaign.ends_by(pbm(1), Outcome::drifted, 8.4, 9.8).tell(PbmExchanged{pbm(1), 1, a_pbm(8.4)});

  const StartBurst second_dem = campaign.only<StartBurst>();
  EXPECT_EQ(dem(1), second_dem.restart);
  EXPECT_EQ(3.0, second_dem.start_time);
  EXPECT_EQ(pbm(1), second_dem.takes_from);

  campaign.ends_by(dem(2), Outcome::converged, 4.0, 4.1).tell(DemExchanged{dem(2), 1, a_dem(3.0, 4.1)});
  const auto& second_pbm = campaign.only<StartBurst>();
  EXPECT_EQ(pbm(1), second_pbm.restart);
  EXPECT_EQ(8.4, second_pbm.restart_time);
  EXPECT_EQ(8.4, second_pbm.start_time);
  EXPECT_EQ(dem(2), second_pbm.takes_from);
  EXPECT_EQ(4.1, campaign.state.dem_clock);
}

TEST(Coupling, WaitsForTheMonitorsLastWordOnAProgramThatWasFaster) {
  Campaign campaign(settings());
  campaign.tell(Began{}).ends_alone(dem(1), 3.0).tell(DemExchanged{dem(1), 1, a_dem(0.0, 3.0)});

  campaign.tell(TaskEnded{pbm(1), 1, TaskEnded::Outcome::finished, 10.0, ""});
  EXPECT_EQ(pbm(1), campaign.only<AskMonitor>().burst);

  campaign.tell(MonitorSpoke{pbm(1), 1, a_verdict(Outcome::drifted, 2.2)});
  EXPECT_EQ(2.2, campaign.only<Exchange>().time);
  EXPECT_EQ("drifted", campaign.state.bursts.back().reason);
}

TEST(Coupling, LetsNoPbmBurstRunPastTheProcessEnd) {
  Settings s = settings();
  s.process_duration = 14.0;
  Campaign campaign(s);
  campaign.tell(Began{}).round(1).ends_alone(dem(2), 6.0).tell(DemExchanged{dem(2), 1, a_dem(3.0, 6.0, 80.0)});

  EXPECT_EQ(4.0, campaign.only<StartBurst>().longest);
  campaign.ends_alone(pbm(2), 14.0).tell(PbmExchanged{pbm(2), 1, a_pbm(14.0)});
  EXPECT_EQ(End::How::limit, campaign.only<End>().how);
  EXPECT_EQ("end", campaign.state.bursts.back().reason);
}

TEST(Coupling, EndsSteadyWhenTheDemIsSteadyAndTwoRoundsAgree) {
  Campaign campaign(settings());
  campaign.tell(Began{}).round(1);
  EXPECT_EQ(dem(2), campaign.only<StartBurst>().burst) << "one round has nothing to be compared with";

  campaign.round(2);

  const auto& end = campaign.only<End>();
  EXPECT_EQ(End::How::steady, end.how);
  EXPECT_EQ(6.0, end.why.numbers["steady_time_s"].as_number()) << "three seconds of each of two bursts";
  EXPECT_EQ(Phase::ended, campaign.state.phase);
}

TEST(Coupling, IsNotSteadyBeforeTheSteadyWindowOfDemTimeIsFull) {
  Settings s = settings();
  s.steady_window = 7.0;
  Campaign campaign(s);

  campaign.tell(Began{}).round(1).round(2);
  EXPECT_EQ(dem(3), campaign.only<StartBurst>().burst);
  campaign.round(3);
  EXPECT_EQ(End::How::steady, campaign.only<End>().how);
}

TEST(Coupling, IsNotSteadyBeforeWhatTheProcessBeginsWithLaterHasGoneThrough) {
  Settings s = settings();
  s.earliest_steady = 25.0;  // a round takes 10 s of the process
  Campaign campaign(s);

  campaign.tell(Began{}).round(1).round(2);
  EXPECT_EQ(dem(3), campaign.only<StartBurst>().burst) << "at " << campaign.state.process_clock << " s";
  campaign.round(3);
  EXPECT_EQ(End::How::steady, campaign.only<End>().how);
}

TEST(Coupling, IsNotSteadyWhileTheCoupledStateChangesBetweenRounds) {
  Campaign campaign(settings());
  campaign.tell(Began{}).round(1, 50.0, 1.0e-4).round(2, 50.0, 1.07e-4);

  const auto& start = campaign.only<StartBurst>();
  EXPECT_EQ(dem(3), start.burst);
  EXPECT_EQ("d50_m", start.why.numbers["too_large_change"]["what"].as_string());
  EXPECT_NEAR(0.07, start.why.numbers["too_large_change"]["change"].as_number(), 1e-9);
}

TEST(Coupling, IsNotSteadyAfterAPbmBurstThatDrifted) {
  Campaign campaign(settings());
  campaign.tell(Began{}).round(1).ends_alone(dem(2), 6.0).tell(DemExchanged{dem(2), 1, a_dem(3.0, 6.0)});

  campaign.ends_by(pbm(2), Outcome::drifted, 12.0, 13.0).tell(PbmExchanged{pbm(2), 1, a_pbm(12.0)});

  EXPECT_EQ(dem(3), campaign.only<StartBurst>().burst);
}

TEST(Coupling, GoesOnAfterASteadyPbmBurstAsLongAsTheRoundsDisagree) {
  Campaign campaign(settings());
  campaign.tell(Began{}).round(1).ends_alone(dem(2), 6.0).tell(DemExchanged{dem(2), 1, a_dem(3.0, 6.0)});

  campaign.ends_by(pbm(2), Outcome::steady, 18.0, 19.0).tell(PbmExchanged{pbm(2), 1, a_pbm(18.0, 1.2e-4)});

  EXPECT_EQ(dem(3), campaign.only<StartBurst>().burst);
}

TEST(Coupling, StartsToCountSteadyTimeAnewWhenTheDemMoves) {
  Campaign campaign(settings());
  campaign.tell(Began{}).round(1, 50.0).round(2, 60.0);
  EXPECT_EQ(3.0, campaign.state.steady_time) << "20 % more collisions: only the second burst counts";

  campaign.ends_by(dem(3), Outcome::drifted, 7.0, 7.0).tell(DemExchanged{dem(3), 1, a_dem(6.0, 7.0, 60.0)});
  EXPECT_EQ(0.0, campaign.state.steady_time) << "and one that drifted counts not at all";
}

TEST(Coupling, SeesASlowWalkOverManyBurstsEachBelowTheThreshold) {
  Settings s = settings();
  s.steady_window = 1000.0;
  Campaign campaign(s);
  campaign.tell(Began{}).round(1, 50.0).round(2, 54.0).round(3, 58.3);

  EXPECT_EQ(3.0, campaign.state.steady_time) << "8 % a burst, but 17 % from the first to the third";
}

TEST(Coupling, EndsAtTheMostRounds) {
  Settings s = settings();
  s.most_rounds = 2;
  Campaign campaign(s);
  campaign.tell(Began{}).round(1, 50.0).round(2, 80.0);

  EXPECT_EQ(End::How::limit, campaign.only<End>().how);
}

TEST(Coupling, OneWayRunsOneDemAndOnePbmToTheEndOfTheProcess) {
  Settings s = settings();
  s.mode = Mode::one_way;
  Campaign campaign(s);
  EXPECT_FALSE(campaign.tell(Began{}).only<StartBurst>().watch_drift);

  campaign.tell(MonitorSpoke{dem(1), 1, a_verdict(Outcome::converged, 1.0)});
  EXPECT_EQ("converged", campaign.only<StopTask>().why.reason);
  campaign.tell(TaskEnded{dem(1), 1, TaskEnded::Outcome::stopped, 1.1, ""})
      .tell(DemExchanged{dem(1), 1, a_dem(0.0, 1.1)});
  EXPECT_EQ(100.0, campaign.only<StartBurst>().longest);
  EXPECT_FALSE(campaign.only<StartBurst>().monitored);
  campaign.tell(TaskEnded{pbm(1), 1, TaskEnded::Outcome::finished, 100.0, ""});
  EXPECT_EQ(100.0, campaign.only<Exchange>().time);
  campaign.tell(PbmExchanged{pbm(1), 1, a_pbm(100.0)});
  EXPECT_EQ(End::How::limit, campaign.only<End>().how);
}

TEST(Coupling, PbmOnlyRunsNoDem) {
  Settings s = settings();
  s.mode = Mode::pbm_only;
  Campaign campaign(s);

  const auto& start = campaign.tell(Began{}).only<StartBurst>();
  EXPECT_EQ(pbm(1), start.burst);
  EXPECT_FALSE(start.takes_from);
  campaign.tell(TaskEnded{pbm(1), 1, TaskEnded::Outcome::finished, 100.0, ""})
      .tell(PbmExchanged{pbm(1), 1, a_pbm(100.0)});
  EXPECT_EQ(End::How::limit, campaign.only<End>().how);
}

TEST(Coupling, FailsWithCauseAndSettingsWhenABurstDiverges) {
  Campaign campaign(settings());
  monitor::Verdict verdict = a_verdict(Outcome::diverged, 0.07);
  verdict.message = "overlap: largest overlap 0.41";
  verdict.details = *json::parse(R"({"settings": ["/dem/time_step", "/dem/contact/young_modulus"]})", "test");

  campaign.tell(Began{}).tell(MonitorSpoke{dem(1), 1, verdict});
  EXPECT_EQ("diverged", campaign.only<StopTask>().why.reason);
  campaign.tell(TaskEnded{dem(1), 1, TaskEnded::Outcome::diverged, 0.07, ""});

  const auto& end = campaign.only<End>();
  EXPECT_EQ(End::How::failed, end.how);
  EXPECT_THAT(end.why.message,
              HasSubstr("0001-dem diverged: overlap: largest overlap 0.41. Settings to look at: /dem/time_step "
                        "/dem/contact/young_modulus."));
}

TEST(Coupling, FailsWhenAProgramFailsForGoodOrItsMonitorOrItsExchange) {
  const auto message_after = [](const Event& event) {
    Campaign campaign(settings());
    campaign.tell(Began{}).tell(event);
    if (campaign.state.phase == Phase::stopping)
      campaign.tell(TaskEnded{dem(1), 1, TaskEnded::Outcome::stopped, 0.3, ""});
    EXPECT_EQ(End::How::failed, campaign.only<End>().how);
    return campaign.state.why_ended.message;
  };

  EXPECT_EQ("0001-dem failed: exit code 139",
            message_after(TaskEnded{dem(1), 1, TaskEnded::Outcome::failed, {}, "exit code 139"}));
  EXPECT_THAT(message_after(MonitorFailed{dem(1), 1, "tallies.jsonl, line 7: cut"}),
              HasSubstr("the monitor of 0001-dem failed: tallies.jsonl, line 7"));

  Campaign campaign(settings());
  campaign.tell(Began{}).ends_alone(dem(1), 3.0).tell(ExchangeFailed{dem(1), 1, "no collision was counted"});
  EXPECT_EQ("0001-dem: no collision was counted", campaign.only<End>().why.message);
}

TEST(Coupling, FailsRatherThanCirclingWhenABurstGetsNowhere) {
  Campaign campaign(settings());
  campaign.tell(Began{}).ends_alone(dem(1), 3.0).tell(DemExchanged{dem(1), 1, a_dem(0.0, 3.0)}).ends_alone(pbm(1), 0.0);

  EXPECT_EQ(End::How::failed, campaign.only<End>().how);
}

TEST(Coupling, StopsGracefullyAndGoesOnWithANewAttempt) {
  Campaign campaign(settings());
  campaign.tell(Began{}).round(1).tell(StopAsked{"asked by the user"});
  EXPECT_EQ(dem(2), campaign.only<StopTask>().burst);
  campaign.tell(TaskEnded{dem(2), 1, TaskEnded::Outcome::stopped, 3.5, ""});
  EXPECT_EQ(End::How::stopped, campaign.only<End>().how);

  campaign.tell(Resumed{});

  const auto& start = campaign.only<StartBurst>();
  EXPECT_EQ(dem(2), start.burst);
  EXPECT_EQ(2, start.attempt);
  EXPECT_EQ(3.0, start.start_time) << "from where the burst began";
  EXPECT_EQ(dem(1), start.restart);
}

TEST(Coupling, BringsAFinishedBurstHomeBeforeItStops) {
  Campaign campaign(settings());
  campaign.tell(Began{}).tell(MonitorSpoke{dem(1), 1, a_verdict(Outcome::drifted, 0.6)}).tell(StopAsked{"walltime"});
  EXPECT_TRUE(campaign.asked.empty()) << "it is being stopped already";

  campaign.tell(TaskEnded{dem(1), 1, TaskEnded::Outcome::stopped, 0.7, ""});
  EXPECT_EQ(dem(1), campaign.only<Exchange>().burst);
  campaign.tell(DemExchanged{dem(1), 1, a_dem(0.0, 0.7)});
  EXPECT_EQ(End::How::stopped, campaign.only<End>().how);

  campaign.tell(Resumed{});
  EXPECT_EQ(pbm(1), campaign.only<StartBurst>().burst);
  EXPECT_EQ(1, campaign.only<StartBurst>().attempt);
}

TEST(Coupling, ResumesAnywhereWithTheActionItWasWaitingFor) {
  const auto resumed_after = [](const std::function<void(Campaign&)>& story) {
    Campaign campaign(settings());
    campaign.tell(Began{});
    story(campaign);
    campaign.tell(Resumed{});
    return campaign.asked.size() == 1 ? json::dump(to_json(campaign.asked[0])).substr(0, 60) : std::string("nothing");
  };

  EXPECT_THAT(resumed_after([](Campaign&) {}), HasSubstr(R"("start_burst","burst":"0001-dem","attempt":2)"));
  EXPECT_THAT(resumed_after([](Campaign& c) {
                c.tell(TaskEnded{dem(1), 1, TaskEnded::Outcome::finished, 3.0, ""});
              }),
              HasSubstr(R"("ask_monitor","burst":"0001-dem","attempt":1)"))
      << "no finished task runs again";
  EXPECT_THAT(resumed_after([](Campaign& c) { c.ends_alone(dem(1), 3.0); }),
              HasSubstr(R"("exchange","burst":"0001-dem","attempt":1)"));
  EXPECT_EQ("nothing", resumed_after([](Campaign& c) { c.round(1).round(2); })) << "it had ended steady";
}

TEST(Coupling, ForgetsWhatItHeardOfAnAttemptThatWasRetried) {
  Campaign campaign(settings());
  campaign.tell(Began{}).tell(MonitorSpoke{dem(1), 1, a_verdict(Outcome::drifted, 0.6)}).tell(TaskStarted{dem(1), 2});
  EXPECT_EQ(Phase::running, campaign.state.phase);

  campaign.tell(MonitorSpoke{dem(1), 1, a_verdict(Outcome::steady, 0.9)});
  EXPECT_TRUE(campaign.asked.empty()) << "the first attempt's monitor, late";
  campaign.tell(MonitorSpoke{dem(1), 2, a_verdict(Outcome::steady, 0.9)});
  EXPECT_EQ(2, campaign.only<StopTask>().attempt);
}

TEST(Coupling, CarriesADecisionInEveryAction) {
  Campaign campaign(settings());
  std::vector<Action> all;
  const auto note = [&](const Event& event) {
    campaign.tell(event);
    all.insert(all.end(), campaign.asked.begin(), campaign.asked.end());
  };
  Campaign story(settings());
  story.tell(Began{}).round(1).round(2);
  for (const Event& event : story.journal) note(event);

  EXPECT_EQ(13u, all.size()) << "four bursts of start, ask and exchange, and the end";
  for (const Action& action : all) {
    const json::Value record = to_json(action);
    EXPECT_FALSE(record["why"].text_or("reason", "").empty()) << json::dump(record);
    EXPECT_FALSE(record["why"].text_or("message", "").empty()) << json::dump(record);
  }
}

// ---- for all stories

/// Every other one is short of process time.
Settings story_settings(unsigned seed) {
  Settings s = settings();
  if (seed % 2 == 0) s.process_duration = 12.0;
  return s;
}

/// A story as chance has it: a program and a monitor that do whatever they may do in answer to the actions.
std::vector<Event> a_random_story(unsigned seed, const Settings& s) {
  std::mt19937 random(seed);
  const auto chance = [&](double p) { return std::bernoulli_distribution(p)(random); };
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<>(a, b)(random); };
  const auto some_verdict = [&] {
    constexpr std::array kAll{Outcome::drifted, Outcome::steady, Outcome::converged, Outcome::ended, Outcome::drifted};
    return kAll[std::uniform_int_distribution<std::size_t>(0, kAll.size() - 1)(random)];
  };
  Campaign campaign(s);
  campaign.tell(Began{});
  for (int step = 0; step < 400 && campaign.state.phase != Phase::ended; ++step) {
    const State& now = campaign.state;
    const double until = now.burst_start + between(0.1, 3.0);
    if (chance(0.01))
      campaign.tell(StopAsked{"chance"});
    else if (chance(0.02))
      campaign.tell(Resumed{});
    else if (now.phase == Phase::running && chance(0.05))
      campaign.tell(TaskStarted{now.burst, now.attempt + 1});
    else if (now.phase == Phase::running && chance(0.5))
      campaign.tell(MonitorSpoke{now.burst, now.attempt, a_verdict(some_verdict(), until)});
    else if (now.phase == Phase::running || now.phase == Phase::stopping)
      campaign.tell(TaskEnded{now.burst, now.attempt,
                              now.phase == Phase::stopping ? TaskEnded::Outcome::stopped : TaskEnded::Outcome::finished,
                              until + 1.0, ""});
    else if (now.phase == Phase::closing)
      campaign.tell(MonitorSpoke{now.burst, now.attempt, a_verdict(some_verdict(), until)});
    else if (now.burst.kind == Kind::dem)
      campaign.tell(DemExchanged{now.burst, now.attempt,
                                 a_dem(now.burst_start, now.bursts.back().end_time, between(45.0, 55.0))});
    else
      campaign.tell(PbmExchanged{now.burst, now.attempt, a_pbm(now.bursts.back().end_time, between(0.95e-4, 1.05e-4))});
  }
  return campaign.journal;
}

TEST(CouplingForAllStories, AJournalReplaysToTheSameState) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    Campaign lived(story_settings(seed)), replayed(story_settings(seed));
    for (const Event& event : a_random_story(seed, story_settings(seed))) {
      lived.tell(event);
      const auto written = json::parse(json::dump(to_json(event)), "journal");
      ASSERT_TRUE(written);
      const auto read = event_from_json(*written);
      ASSERT_TRUE(read) << read.error().message;
      replayed.tell(*read);
    }
    ASSERT_EQ(lived.state, replayed.state) << "seed " << seed;
  }
}

/// Those that a program or a file may repeat; the three that people send mean something new each time.
bool may_come_twice(const Event& event) {
  return !std::holds_alternative<Began>(event) && !std::holds_alternative<Resumed>(event) &&
         !std::holds_alternative<StopAsked>(event);
}

TEST(CouplingForAllStories, EventsThatComeTwiceOrLateChangeNothing) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    Campaign campaign(story_settings(seed));
    std::vector<Event> heard;
    for (const Event& event : a_random_story(seed, story_settings(seed))) {
      campaign.tell(event);
      const State before = campaign.state;
      if (may_come_twice(event)) heard.push_back(event);
      for (int again = 0; again < 3 && !heard.empty(); ++again) {
        const std::size_t which =
            again == 0 ? heard.size() - 1 : std::uniform_int_distribution<std::size_t>(0, heard.size() - 1)(random);
        campaign.tell(heard[which]);
        ASSERT_EQ(before, campaign.state) << "seed " << seed << ": " << json::dump(to_json(heard[which]));
        ASSERT_TRUE(campaign.asked.empty()) << "seed " << seed;
      }
    }
  }
}

TEST(CouplingForAllStories, BothClocksOnlyGoForwardAndEachBurstStartsWhereItsKindEnded) {
  std::size_t bursts = 0;
  std::set<End::How> ends;
  for (unsigned seed = 0; seed < 300; ++seed) {
    Campaign campaign(story_settings(seed));
    for (const Event& event : a_random_story(seed, story_settings(seed))) campaign.tell(event);
    double clock[2] = {0.0, 0.0};
    int round = 1;
    for (const BurstRecord& burst : campaign.state.bursts) {
      double& own = clock[burst.burst.kind == Kind::dem ? 0 : 1];
      ASSERT_EQ(own, burst.start_time) << "seed " << seed;
      ASSERT_GT(burst.end_time, burst.start_time);
      own = burst.end_time;
      ASSERT_EQ(round, burst.burst.round) << "DEM and PBM take turns";
      if (burst.burst.kind == Kind::pbm) ++round;
    }
    bursts += campaign.state.bursts.size();
    if (campaign.state.ended) ends.insert(*campaign.state.ended);
  }
  EXPECT_GT(bursts, 2000u) << "or the stories are too short to show anything";
  EXPECT_THAT(ends, ::testing::IsSupersetOf({End::How::steady, End::How::limit, End::How::stopped}));
}

TEST(CouplingEvent, RefusesARecordItDoesNotKnow) {
  for (const char* text :
       {R"({"event": "task_vanished", "round": 1, "kind": "dem", "attempt": 1})", R"({"event": "task_ended"})",
        R"({"event": "task_ended", "round": 1, "kind": "dem", "attempt": 1, "outcome": "bored"})"})
    EXPECT_FALSE(event_from_json(*json::parse(text, "journal"))) << text;
}

}  // namespace
}  // namespace granary::coupling
