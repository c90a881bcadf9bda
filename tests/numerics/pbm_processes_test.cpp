// Whole runs in memory: flow, consolidation, spray, conservation, positivity, threads, and the cases that break
// solvers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "pbm_solver/output/summary.hpp"
#include "pbm_solver/time/simulation.hpp"
#include "tests/support/pbm_cases.hpp"

namespace granary::pbm {
namespace {

/// Runs a case in steps of output_every; `look` sees the state at each.
Result<Snapshot> run(const PbmCase& c, int threads = 1, const std::function<void(const Snapshot&)>& look = {}) {
  Alone alone(c.compartments.count);
  Simulation simulation(c, initial_snapshot(c, ClassGrid(c.grid)), alone, threads);
  for (int n = 1; simulation.time() < c.end_time; ++n) {
    GRANARY_TRY(const bool reached, simulation.advance(std::min(c.end_time, n * c.output_every)));
    EXPECT_TRUE(reached);
    if (look) look(simulation.snapshot());
  }
  return simulation.snapshot();
}

void expect_conserved_and_positive(const Snapshot& s, const PbmCase& c, double tolerance = 1e-12) {
  const Drift d = drift(s, ClassGrid(c.grid));
  EXPECT_LT(d.solid_1, tolerance);
  EXPECT_LT(d.solid_2, tolerance);
  EXPECT_LT(d.liquid, tolerance);
  EXPECT_LT(d.gas, tolerance);
  for (const auto* field : {&s.number, &s.liquid, &s.gas})
    for (const double value : *field) ASSERT_GE(value, 0.0);
}

TEST(Flow, FillsCompartmentsAsTanksInSeries) {
  PbmCase c = testing::a_case(3);
  c.compartments = {5, std::vector<double>(5, 1.0), 10.0};
  c.feed = Feed{};
  c.feed->classes = {{1, 2, 7.0}};
  c.feed->porosity = 0.25;
  c.end_time = 6.0;
  c.output_every = 1.5;
  c.relative_tolerance = 1e-7;
  const double k = 0.5, gas_each = (3.0 + 9.0) / 3.0;

  const auto end = run(c, 1, [&](const Snapshot& s) {
    for (int m = 1; m <= 5; ++m) {
      double sum = 0.0, term = 1.0;
      for (int r = 0; r < m; ++r, term *= k * s.time / r) sum += term;
      const double expected = 7.0 / k * (1.0 - std::exp(-k * s.time) * sum);
      const std::size_t at = static_cast<std::size_t>(m - 1) * 9 + 5;
      EXPECT_NEAR(s.number[at], expected, 2e-6 * expected + 1e-6) << "compartment " << m << " at " << s.time;
      EXPECT_NEAR(s.gas[at], expected * gas_each, 1e-5 * expected + 1e-5);
    }
  });

  ASSERT_TRUE(end);
  expect_conserved_and_positive(*end, c);
}

TEST(Consolidation, BringsPorosityDownExponentially) {
  PbmCase c = testing::a_case(4);
  c.materials.saturation_factor = 100.0;  // all liquid inside
  c.consolidation = Consolidation{0.4, 0.2};
  c.initial = {{0, 1, 2, 10.0, 24.0, 156.0}};  // s = 12 each: eps = 180 / 300 = 0.6
  c.end_time = 5.0;
  c.output_every = 1.0;
  c.relative_tolerance = 1e-8;

  const auto end = run(c, 1, [&](const Snapshot& s) {
    const double pores = s.liquid[6] + s.gas[6];
    EXPECT_NEAR(pores / (120.0 + pores), 0.2 + 0.4 * std::exp(-0.4 * s.time), 1e-7);
  });

  ASSERT_TRUE(end);
  expect_conserved_and_positive(*end, c);
}

TEST(Spray, AddsExactlyItsRateBetweenItsTimes) {
  PbmCase c = testing::a_case(4);
  c.spray = Spray{3.0, 0, 0.35, 1.15};
  c.initial = {{0, 0, 0, 5.0, 1.0, 0.0}, {0, 2, 1, 2.0, 0.0, 0.0}};
  c.end_time = 2.0;
  c.output_every = 0.25;

  const auto end = run(c);

  ASSERT_TRUE(end);
  double liquid = 0.0;
  for (const double l : end->liquid) liquid += l;
  EXPECT_NEAR(liquid, 1.0 + 3.0 * 0.8, 1e-13);
  // 2.4 shared as the solids are: 10 in (0,0), 24 in (2,1).
  EXPECT_NEAR(end->liquid[9], 2.4 * 24.0 / 34.0, 1e-13);
  expect_conserved_and_positive(*end, c);
}

TEST(Granulator, ClosesEveryBalanceWithEverythingOn) {
  PbmCase c = testing::a_granulator(10, 3);
  c.end_time = 8.0;

  const auto end = run(c, 1, [&](const Snapshot& s) { expect_conserved_and_positive(s, c); });

  ASSERT_TRUE(end);
  const Summary s = summarize(*end, c, ClassGrid(c.grid));
  EXPECT_GT(s.oversize, 0.0);
  EXPECT_GT(end->ledger[ledger::kConsolidated], 0.0);
  EXPECT_GT(s.outlet_mass_rate, 0.0);
}

TEST(Granulator, GivesTheSameBitsForAnyNumberOfThreads) {
  for (const int n_compartments : {1, 3}) {
    PbmCase c = testing::a_granulator(10, n_compartments);
    c.end_time = 3.2;

    const auto one = run(c, 1), two = run(c, 2), five = run(c, 5);

    ASSERT_TRUE(one && two && five);
    for (const auto* other : {&*two, &*five}) {
      EXPECT_EQ(one->number, other->number);
      EXPECT_EQ(one->liquid, other->liquid);
      EXPECT_EQ(one->gas, other->gas);
      EXPECT_EQ(one->ledger, other->ledger);
      EXPECT_EQ(one->next_step, other->next_step);
    }
  }
}

TEST(Granulator, GivesTheSameBitsForAnyNumberOfThreadsWhereStepsAreImplicit) {
  PbmCase c = testing::a_granulator(8, 20);
  c.breakage->rate = 1e4;
  c.end_time = 1.6;
  Alone alone(c.compartments.count);
  std::vector<Snapshot> ends;
  for (const int threads : {1, 2, 5}) {
    Simulation simulation(c, initial_snapshot(c, ClassGrid(c.grid)), alone, threads);
    ASSERT_TRUE(simulation.advance(c.end_time));
    EXPECT_GT(simulation.work().implicit_steps, 0);
    ends.push_back(simulation.snapshot());
  }

  expect_conserved_and_positive(ends[0], c);
  for (const std::size_t other : {1, 2}) {
    EXPECT_EQ(ends[0].number, ends[other].number);
    EXPECT_EQ(ends[0].liquid, ends[other].liquid);
    EXPECT_EQ(ends[0].ledger, ends[other].ledger);
    EXPECT_EQ(ends[0].next_step, ends[other].next_step);
  }
}

TEST(Granulator, HardlyDependsOnTheTolerance) {
  PbmCase c = testing::a_granulator(10, 2);
  c.end_time = 6.0;
  const auto usual = run(c);
  c.relative_tolerance = 1e-6;
  const auto tight = run(c);

  ASSERT_TRUE(usual && tight);
  const ClassGrid grid(c.grid);
  const Summary a = summarize(*usual, c, grid), b = summarize(*tight, c, grid);
  for (std::size_t x = 0; x < 2; ++x) {
    EXPECT_NEAR(a.number[x] / b.number[x], 1.0, 2e-3);
    EXPECT_NEAR(a.d50[x] / b.d50[x], 1.0, 2e-3);
  }
}

TEST(HardCase, TwoPureComponentsMixWithoutLoss) {
  // Granules of almost only one solid each, as two classes: discontinuous data.
  PbmCase c = testing::a_case(14);
  c.grid.ratio = {2.0, 2.0};
  c.initial = {{0, 8, 0, 500.0, 0.0, 0.0}, {0, 0, 8, 500.0, 40.0, 0.0}};
  c.aggregation = Aggregation{};
  c.aggregation->rate = 0.02;
  c.end_time = 1.0;

  const auto end = run(c, 1, [&](const Snapshot& s) { expect_conserved_and_positive(s, c); });

  ASSERT_TRUE(end);
  double number = end->ledger[ledger::kOversizeNumber], left = 0.0;
  for (const double n : end->number) left += n;
  EXPECT_NEAR(left + number, 1000.0 / (1.0 + 0.5 * 0.02 * 1000.0), 0.2 + number);
  // The mirror image of the start gives the mirror image of the numbers.
  for (int i = 0; i < 14; ++i)
    for (int j = 0; j < i; ++j) EXPECT_NEAR(end->number[i * 14 + j], end->number[j * 14 + i], 1e-9);
}

TEST(HardCase, OneSizeFedIntoAnEmptyMachine) {
  PbmCase c = testing::a_case(12);
  c.grid.ratio = {2.0, 2.0};
  c.compartments = {3, {1.0, 1.0, 1.0}, 6.0};
  c.feed = Feed{};
  c.feed->classes = {{0, 0, 1e6}};
  c.feed->porosity = 0.4;
  c.feed->start = 0.13;
  c.feed->end = 3.21;
  c.aggregation = Aggregation{};
  c.aggregation->rate = 1e-5;
  c.spray = Spray{1e5, 1, 0.05, 2.0};
  c.end_time = 6.0;

  const auto end = run(c, 1, [&](const Snapshot& s) { expect_conserved_and_positive(s, c); });

  ASSERT_TRUE(end) << end.error().message;
  EXPECT_GT(end->number[2 * 144], 0.0);
}

TEST(HardCase, BreakageFarFasterThanAnythingElse) {
  // Rates over nine decades on one grid: the largest classes are gone in a microsecond.
  PbmCase c = testing::a_case(10);
  c.breakage = Breakage{};
  c.breakage->selection = Breakage::Selection::linear;
  c.breakage->rate = 1e3;
  c.reference_volume = 4e4;
  c.aggregation = Aggregation{};
  c.aggregation->rate = 1e-3;
  c.initial = {{0, 9, 9, 10.0, 1e5, 3e5}, {0, 2, 2, 1e3, 0.0, 5e3}};
  c.end_time = 1.0;

  const auto end = run(c, 1, [&](const Snapshot& s) { expect_conserved_and_positive(s, c); });

  ASSERT_TRUE(end) << end.error().message;
  EXPECT_LT(end->number[99], 1e-6);
}

TEST(HardCase, EverythingGrowsBeyondTheGrid) {
  PbmCase c = testing::a_case(5);
  c.aggregation = Aggregation{};
  c.aggregation->kernel = Aggregation::Kernel::product;
  c.aggregation->rate = 1.0;
  c.initial = {{0, 0, 0, 100.0, 10.0, 20.0}};
  c.end_time = 3.0;

  const auto end = run(c, 1, [&](const Snapshot& s) { expect_conserved_and_positive(s, c); });

  ASSERT_TRUE(end) << end.error().message;
  const Summary s = summarize(*end, c, ClassGrid(c.grid));
  EXPECT_GT(s.oversize, 0.5 * 200.0);
  EXPECT_NEAR(s.oversize + s.solid[0], 200.0, 1e-10);
}

TEST(HardCase, RatesOverTwentyDecadesScaleAway) {
  // The same process with beta 10^10 larger in a time 10^10 shorter takes the same steps.
  PbmCase c = testing::a_case(8);
  c.aggregation = Aggregation{};
  c.aggregation->rate = 1e-10;
  c.initial = {{0, 0, 0, 1e10, 0.0, 1e9}};
  c.end_time = 1.0, c.output_every = 0.5;
  PbmCase fast = c;
  fast.aggregation->rate = std::ldexp(1e-10, 40);
  fast.end_time = std::ldexp(1.0, -40), fast.output_every = std::ldexp(0.5, -40);

  const auto a = run(c), b = run(fast);

  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->number, b->number);
}

TEST(HardCase, NothingAtAllStaysNothing) {
  PbmCase c = testing::a_granulator(6, 2);
  c.feed.reset();
  c.end_time = 1.0;

  const auto end = run(c);

  ASSERT_TRUE(end) << end.error().message;
  for (const auto* field : {&end->number, &end->liquid, &end->gas})
    for (const double value : *field) EXPECT_EQ(value, 0.0);
}

TEST(Integrator, SaysWhichSettingsToLookAtWhenItCannotKeepItsTolerance) {
  PbmCase c = testing::a_case(8);
  c.aggregation = Aggregation{};
  c.aggregation->rate = 1e30;
  c.initial = {{0, 0, 0, 1e10, 0.0, 0.0}};

  const auto end = run(c);

  ASSERT_FALSE(end);
  EXPECT_EQ(static_cast<int>(end.error().exit), 20);
  for (const char* word : {"/relative_tolerance", "/aggregation/rate", "/breakage/rate", "/grid"})
    EXPECT_NE(end.error().message.find(word), std::string::npos) << end.error().message;
}

}  // namespace
}  // namespace granary::pbm
