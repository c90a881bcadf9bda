#include "controller/monitor/criteria.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace granary::monitor {
namespace {

constexpr double kWindow = 0.01;

Options options() {
  Options o;
  o.grace = 0.0;
  o.steady_window = 0.0;
  return o;
}

/// Counts per window as the monitor sees a DEM's collisions.
Row counts(int window, double count) {
  const double begin = window * kWindow;
  return {
      begin, begin + kWindow, {{count / kWindow, std::sqrt(std::max(count, 1.0)) / kWindow, 20.0 / (3.0 * kWindow)}}};
}

/// The first verdict on n windows of what `value` says, or `none`.
Verdict judge(const Options& o, int n, const std::function<double(int)>& count) {
  Criteria criteria(o, {{"collisions_per_s", "all", true}});
  for (int w = 0; w < n; ++w)
    if (Verdict said = criteria.add(counts(w, count(w))); said.outcome != Outcome::none) return said;
  return {};
}

TEST(Criteria, SaysDriftedForAChangeOfEitherSign) {
  for (const double sign : {+1.0, -1.0}) {
    const Verdict said = judge(options(), 40, [&](int w) { return w < 20 ? 5000.0 : 5000.0 * (1.0 + sign * 0.2); });

    EXPECT_EQ(Outcome::drifted, said.outcome);
    EXPECT_NEAR(sign * 0.2, said.change, 1e-12);
    EXPECT_NEAR(5000.0 / kWindow, said.reference, 1e-6);
    EXPECT_NEAR(0.23, said.time, 1e-12) << "three windows are the value: the first mean beyond 15 % holds all three";
    EXPECT_EQ("collisions_per_s", said.watched);
  }
}

TEST(Criteria, SaysNothingForAChangeBelowTheThreshold) {
  EXPECT_EQ(Outcome::none, judge(options(), 40, [](int w) { return w < 20 ? 5000.0 : 5700.0; }).outcome);
}

TEST(Criteria, CountsAChangeOnlyBeyondItsCountingNoise) {
  const auto forty_percent_more = [](double count) { return [count](int w) { return w < 3 ? count : 1.4 * count; }; };

  EXPECT_EQ(Outcome::none, judge(options(), 6, forty_percent_more(25.0)).outcome)
      << "75 against 105 counts: 2.2 standard errors";
  EXPECT_EQ(Outcome::drifted, judge(options(), 6, forty_percent_more(250.0)).outcome);
}

TEST(Criteria, IgnoresChangesOfWhatIsSmallerThanItsFloor) {
  Options o = options();
  o.significance = 0.0;

  EXPECT_EQ(Outcome::none, judge(o, 6, [](int w) { return w < 3 ? 0.0 : 0.9; }).outcome)
      << "nearly nothing after nothing";
  EXPECT_EQ(Outcome::drifted, judge(o, 6, [](int w) { return w < 3 ? 0.0 : 100.0; }).outcome);
}

TEST(Criteria, LeavesOutWhatIsTooThinToWatch) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Criteria criteria(options(), {{"speed_mean_m_s", "class 1", false}});

  for (int w = 0; w < 20; ++w) {
    const double value = w == 1 ? nan : 1.0 + w;
    EXPECT_EQ(Outcome::none, criteria.add({w * kWindow, (w + 1) * kWindow, {{value, 0.0, 0.0}}}).outcome);
  }
}

TEST(Criteria, LooksAtNothingBeforeTheGraceTime) {
  Options o = options();
  const auto settles_in_50_ms = [](int w) { return w < 5 ? 1000.0 : 5000.0; };

  o.grace = 0.04;
  EXPECT_EQ(Outcome::drifted, judge(o, 40, settles_in_50_ms).outcome);
  o.grace = 0.05;
  EXPECT_EQ(Outcome::none, judge(o, 40, settles_in_50_ms).outcome);
}

TEST(Criteria, RarelyTakesPoissonNoiseForADrift) {
  std::mt19937 random(7);
  std::poisson_distribution<int> noise(60);
  int drifts = 0;
  for (int run = 0; run < 300; ++run)
    if (judge(options(), 300, [&](int) { return noise(random); }).outcome == Outcome::drifted) ++drifts;

  EXPECT_LE(drifts, 3) << "of 300 runs of 300 windows with nothing but noise";
}

TEST(Criteria, SaysSteadyOnceNothingMovedOverTheWholeWindow) {
  Options o = options();
  o.grace = 0.05;
  o.steady_window = 0.2;

  const Verdict said = judge(o, 100, [](int w) { return 5000.0 + 100.0 * (w % 2); });

  EXPECT_EQ(Outcome::steady, said.outcome);
  EXPECT_NEAR(0.25, said.time, 1e-12) << "grace time and steady window";
  EXPECT_LT(said.change, 0.15);
}

TEST(Criteria, IsNotSteadyWhileItMovesWithinTheWindow) {
  Options o = options();
  o.steady_window = 0.2;
  o.watch_drift = false;

  EXPECT_EQ(Outcome::none, judge(o, 200, [](int w) { return 20000.0 * std::exp(0.012 * w); }).outcome)
      << "24 % a window";
  EXPECT_EQ(Outcome::steady, judge(o, 200, [](int w) { return 20000.0 * std::exp(0.004 * w); }).outcome)
      << "8 % a window";
}

TEST(Criteria, IsNotSteadyOnCountsTooFewToShowAMove) {
  Options o = options();
  o.steady_window = 0.2;

  EXPECT_EQ(Outcome::none, judge(o, 200, [](int) { return 40.0; }).outcome)
      << "120 counts a value: 9 % noise hides 15 %";
}

TEST(Criteria, SaysConvergedAtTheStandardErrorOfTheCounts) {
  std::mt19937 random(3);
  std::poisson_distribution<int> noise(100);
  Options o = options();
  o.converged_tolerance = 0.02;

  const Verdict said = judge(o, 1000, [&](int) { return noise(random); });

  EXPECT_EQ(Outcome::converged, said.outcome);
  EXPECT_LE(said.change, 0.02);
  EXPECT_GE(said.lines, 25u) << "2 % takes 2500 counts";
  EXPECT_LT(said.lines, 80u);
}

TEST(Criteria, IsNotConvergedWhileTheMeanStillWanders) {
  Options o = options();
  o.converged_tolerance = 0.02;
  o.watch_drift = false;

  EXPECT_EQ(Outcome::none, judge(o, 100, [](int w) { return 1e5 * (1.0 + 0.01 * w); }).outcome);
}

TEST(Criteria, NeverSaysDriftedWhenToldNotTo) {
  Options o = options();
  o.watch_drift = false;

  EXPECT_EQ(Outcome::none, judge(o, 40, [](int w) { return 1000.0 * (w + 1); }).outcome);
}

}  // namespace
}  // namespace granary::monitor
