#include "controller/monitor/watched.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/json/io.hpp"
#include "tests/unit/controller/monitor_lines.hpp"

namespace granary::monitor {
namespace {

using test::a_progress_header;
using test::a_progress_line;
using test::a_tally_header;
using test::TallyLine;
using ::testing::AllOf;
using ::testing::HasSubstr;

Options no_grace(Program program) {
  Options options = default_options(program);
  options.grace = 0.0;
  options.steady_window = 0.0;
  return options;
}

/// The first verdict on the lines after a header; fails the test on a bad line.
Verdict judge(Program program, const std::vector<json::Value>& lines) {
  Watch watch(program, no_grace(program), "burst");
  for (const json::Value& line : lines) {
    const auto said = watch.take(line);
    if (!said) ADD_FAILURE() << said.error().message;
    if (!said || said->outcome != Outcome::none) return said.value_or({});
  }
  return watch.ended();
}

std::vector<json::Value> tallies(int n, const std::function<void(int, TallyLine&)>& change) {
  std::vector<json::Value> lines{a_tally_header()};
  for (int w = 0; w < n; ++w) {
    TallyLine line;
    line.time = 0.01 * (w + 1);
    change(w, line);
    lines.push_back(line.json());
  }
  return lines;
}

TEST(WatchedDrift, SeesCollisionsImpactsAndMeanSpeedsOfADemDrift) {
  const auto of = [](auto change) {
    return judge(Program::dem, tallies(12, [&](int w, TallyLine& line) {
                   if (w >= 6) change(line);
                 }));
  };

  EXPECT_EQ("collisions_per_particle_s", of([](TallyLine& line) { line.collisions *= 1.3; }).watched);
  EXPECT_EQ("impacts_per_particle_s", of([](TallyLine& line) { line.impacts *= 0.7; }).watched);
  const Verdict speed = of([](TallyLine& line) { line.speed *= 1.3; });
  EXPECT_EQ("speed_mean_m_s", speed.watched);
  EXPECT_EQ("class 1", speed.where);
  EXPECT_EQ(Outcome::ended, of([](TallyLine& line) { line.thin_speed *= 3.0; }).outcome)
      << "ten particles are too few to watch";
}

TEST(WatchedDrift, SeesD50AndNumberOfEachCompartmentOfAPbmDrift) {
  const auto of = [](const std::vector<double>& d50, const std::vector<double>& number) {
    return judge(Program::pbm, {a_progress_header(), a_progress_line(8.0, {4e-5, 5e-5}, {1e9, 2e9}, {1e-5, 1e-5}),
                                a_progress_line(8.2, d50, number, {1e-5, 1e-5})});
  };

  const Verdict d50 = of({4e-5, 6e-5}, {1e9, 2e9});
  EXPECT_EQ(Outcome::drifted, d50.outcome);
  EXPECT_EQ("d50_m", d50.watched);
  EXPECT_EQ("compartment 2", d50.where);
  EXPECT_NEAR(0.2, d50.change, 1e-12);
  EXPECT_EQ(8.2, d50.time);
  EXPECT_EQ(8.0, d50.burst_start);
  EXPECT_EQ("number", of({4e-5, 5e-5}, {0.8e9, 2e9}).watched);
  EXPECT_EQ(Outcome::ended, of({4.4e-5, 5.5e-5}, {1.1e9, 2.2e9}).outcome);
}

TEST(WatchedDrift, IgnoresWhatHappensInANearlyEmptyCompartment) {
  const Verdict said =
      judge(Program::pbm, {a_progress_header(), a_progress_line(0.0, {4e-5, 1e-5}, {1e9, 1e3}, {1e-5, 1e-12}),
                           a_progress_line(0.2, {4e-5, 9e-5}, {1e9, 5e3}, {1e-5, 1e-12})});

  EXPECT_EQ(Outcome::ended, said.outcome) << said.message;
}

TEST(WatchedDrift, SeesTheHoldUpArriveInAnEmptyCompartment) {
  const Verdict said =
      judge(Program::pbm, {a_progress_header(), a_progress_line(0.0, {4e-5, 0.0}, {1e9, 0.0}, {1e-5, 0.0}),
                           a_progress_line(0.2, {4e-5, 4e-5}, {1e9, 1e8}, {1e-5, 1e-6})});

  EXPECT_EQ(Outcome::drifted, said.outcome);
  EXPECT_EQ("compartment 2", said.where);
}

TEST(WatchedDrift, StartsAtTheFirstParticlesOfAProcessThatFillsFromNothing) {
  const Verdict said =
      judge(Program::pbm, {a_progress_header(), a_progress_line(0.0, {0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}),
                           a_progress_line(0.2, {4e-5, 4e-5}, {1e9, 1e9}, {1e-5, 1e-5}),
                           a_progress_line(0.4, {4e-5, 4e-5}, {1.1e9, 1.1e9}, {1e-5, 1e-5})});

  EXPECT_EQ(Outcome::ended, said.outcome) << said.message;
}

TEST(WatchedDrift, PassesOnWhatTheProgramSaysOfItsDivergence) {
  const auto line = json::parse(R"({"diverged": {"cause": "overlap", "value": 0.41, "bound": 0.2, "time_s": 0.071,
                                    "message": "largest overlap 0.41", "settings": ["/dem/time_step"]}})",
                                "test");

  const Verdict said = judge(Program::dem, {a_tally_header(), *line});

  EXPECT_EQ(20, exit_code(said.outcome));
  EXPECT_EQ("overlap", said.watched);
  EXPECT_EQ(0.41, said.value);
  EXPECT_EQ(0.2, said.threshold);
  EXPECT_EQ("/dem/time_step", said.details["settings"].items()[0].as_string());
}

TEST(WatchedDrift, CallsAPbmThatIsNotANumberDiverged) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Verdict said =
      judge(Program::pbm, {a_progress_header(), a_progress_line(0.2, {4e-5, nan}, {1e9, 1e9}, {1e-5, 1e-5})});

  EXPECT_EQ(Outcome::diverged, said.outcome);
  EXPECT_THAT(said.message, HasSubstr("d50_m in compartment 2 is not a number"));
}

TEST(WatchedDrift, NamesFileLineAndMemberOfABadLine) {
  Watch watch(Program::dem, no_grace(Program::dem), "0001-dem/tallies.jsonl");
  ASSERT_TRUE(watch.take(a_tally_header()));
  json::Value short_line = TallyLine{}.json();
  short_line.set("collisions_by_compartment", std::vector<double>{1.0, 2.0});

  const auto said = watch.take(short_line);

  ASSERT_FALSE(said);
  EXPECT_THAT(said.error().message, AllOf(HasSubstr("0001-dem/tallies.jsonl, line 2"),
                                          HasSubstr("/collisions_by_compartment has 2 numbers; the "
                                                    "header promises 1"),
                                          HasSubstr("run the burst again")));
  EXPECT_EQ(Exit::bad_input, said.error().exit);
}

TEST(WatchedDrift, RefusesAFileOfAnotherProgram) {
  Watch watch(Program::dem, no_grace(Program::dem), "tallies.jsonl");
  EXPECT_FALSE(watch.take(a_progress_header()));
}

TEST(Verdict, ReadsBackFromItsOwnLine) {
  const Verdict said =
      judge(Program::dem, tallies(12, [](int w, TallyLine& line) { line.collisions *= 1.0 + 0.1 * w; }));
  ASSERT_EQ(Outcome::drifted, said.outcome);

  const auto line = json::parse(json::dump(to_json(said)), "test");

  EXPECT_EQ(said, verdict_from_json(*line));
  for (const char* key : {"verdict", "watched", "where", "reference", "value", "change", "threshold", "time_s",
                          "burst_start_s", "lines", "message"})
    EXPECT_NE(nullptr, line->find(key)) << key << " is promised by docs/exchange_formats.md";
}

}  // namespace
}  // namespace granary::monitor
