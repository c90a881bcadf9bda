// The two Runge-Kutta methods, the stiff part, and which of them a step takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pbm_solver/time/simulation.hpp"
#include "pbm_solver/time/stiff_part.hpp"
#include "tests/support/pbm_cases.hpp"

namespace granary::pbm {
namespace {

struct Taken {
  double end = 0.0, error = 0.0;
};

/// One step of y' = e(y) + b y.
template <class Explicit>
Taken take_step(const AdditiveMethod& m, double y, double h, Explicit e, double b) {
  std::array<double, AdditiveMethod::kMost> rate_e{}, rate_b{};
  double stage = y;
  rate_e[0] = e(y);
  for (std::size_t i = 1; i <= m.evaluations; ++i) {
    double right = y;
    for (std::size_t j = 0; j < i; ++j) right += h * (m.e[i][j] * rate_e[j] + m.b[i][j] * rate_b[j]);
    stage = right / (1.0 - h * m.gamma * b);
    rate_b[i] = b * stage;
    if (i < m.evaluations) rate_e[i] = e(stage);
  }
  double error = 0.0;
  for (std::size_t j = 0; j < AdditiveMethod::kMost; ++j)
    error += h * (m.error_e[j] * rate_e[j] + m.error_b[j] * rate_b[j]);
  return {stage, error};
}

/// y' = -y^2 + b y from 1, as steps; the exact answer by Bernoulli's substitution.
double error_after(const AdditiveMethod& m, int steps, double b) {
  double y = 1.0;
  const double h = 1.0 / steps;
  const auto explicit_part = [&](double u) { return m.implicit() ? -u * u : -u * u + b * u; };
  for (int n = 0; n < steps; ++n) y = take_step(m, y, h, explicit_part, m.implicit() ? b : 0.0).end;
  const double exact = b * std::exp(b) / (b + std::expm1(b));
  return std::abs(y - exact);
}

TEST(AdditiveMethod, HasOrderThreeWithAndWithoutAnImplicitPart) {
  for (const AdditiveMethod& m : {explicit_method(), implicit_explicit_method()}) {
    const double order = std::log2(error_after(m, 40, -2.0) / error_after(m, 80, -2.0));
    EXPECT_NEAR(order, 3.0, 0.1) << m.gamma;
  }
}

TEST(AdditiveMethod, EstimatesAnErrorOfTheThirdPowerOfTheStep) {
  for (const AdditiveMethod& m : {explicit_method(), implicit_explicit_method()}) {
    const auto estimate = [&](double h) {
      const auto e = [&](double u) { return m.implicit() ? -u * u : -u * u - 2.0 * u; };
      return std::abs(take_step(m, 1.0, h, e, m.implicit() ? -2.0 : 0.0).error);
    };
    EXPECT_NEAR(std::log2(estimate(0.01) / estimate(0.005)), 3.0, 0.1) << m.gamma;
  }
}

TEST(AdditiveMethod, LetsWhatDecaysStayPositiveWhateverTheStep) {
  const AdditiveMethod m = implicit_explicit_method();
  for (double z = 1e-3; z < 1e9; z *= 1.1) {
    const double left = take_step(
                            m, 1.0, 1.0, [](double) { return 0.0; }, -z)
                            .end;
    EXPECT_GT(left, 0.0) << z;
    EXPECT_LE(left, std::max(1.2 * std::exp(-z), 30.0 / z)) << z;
  }
}

TEST(AdditiveMethod, BringsWhatIsFastIntoBalanceInOneStep) {
  const Taken taken = take_step(
      implicit_explicit_method(), 0.0, 1.0, [](double) { return 3.0; }, -1e8);

  EXPECT_NEAR(taken.end / 3e-8, 1.0, 1e-6);
}

PbmCase stiff_case() {
  PbmCase c = testing::a_case(8);
  c.initial = {{0, 2, 3, 100.0, 30.0, 50.0}, {0, 6, 6, 0.1, 30.0, 50.0}};
  c.aggregation = Aggregation{};
  c.aggregation->rate = 0.1;
  c.breakage = Breakage{};
  c.breakage->selection = Breakage::Selection::power;
  c.breakage->exponent = 1.5;
  c.breakage->rate = 1e-2;
  c.end_time = c.output_every = 1.0;
  return c;
}

TEST(StiffPart, IsInvertedToRoundOffWithItsLedger) {
  const PbmCase c = stiff_case();
  const ModelTables tables(c);
  Alone alone(1);
  CompartmentRow row(tables, alone, 1);
  LaneVector state(row.size()), rates(row.size());
  for (std::size_t k = 0; k < row.classes(); ++k)
    for (std::size_t q = 0; q < 3; ++q) state[row.at(0, q * row.classes() + k)] = 1.0 + std::sin(3.0 * k + q);
  row.begin_step(state, true);
  row.rates(state, {}, {}, rates);
  StiffPart stiff(row, 1);
  stiff.freeze();

  for (const double gamma : {1e-6, 1.0, 1e6}) {
    LaneVector solved = state;
    stiff.solve(gamma, solved);
    LaneVector back = solved;
    stiff.add(-gamma, solved, back);
    for (std::size_t k = 0; k < state.size(); ++k) {
      const double scale = std::abs(state[k]) + gamma * std::abs(rates[k]);
      EXPECT_NEAR(back[k], state[k], 1e-12 * scale) << gamma << " at " << k;
    }
  }
}

struct Ended {
  Snapshot state;
  WorkCount work;
};

Ended run(const PbmCase& c, double tolerance, int outputs = 1) {
  PbmCase with = c;
  with.relative_tolerance = tolerance;
  Alone alone(c.compartments.count);
  Simulation simulation(with, initial_snapshot(with, ClassGrid(c.grid)), alone, 1);
  for (int n = 1; n <= outputs; ++n) {
    const auto reached = simulation.advance(c.end_time * n / outputs);
    EXPECT_TRUE(reached) << reached.error().message;
  }
  return {simulation.snapshot(), simulation.work()};
}

double l1(const std::vector<double>& a, const std::vector<double>& b) {
  double off = 0.0, all = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) off += std::abs(a[k] - b[k]), all += std::abs(b[k]);
  return off / all;
}

TEST(Integrator, TakesStiffBreakageImplicitlyAndEverythingElseNot) {
  PbmCase c = stiff_case();
  EXPECT_GT(run(c, 1e-3).work.implicit_steps, 10);

  c.breakage->rate = 1e-9;
  EXPECT_EQ(run(c, 1e-3).work.implicit_steps, 0);

  c.breakage.reset();
  EXPECT_EQ(run(c, 1e-3).work.implicit_steps, 0);
}

TEST(Integrator, KeepsItsToleranceBalancesAndSignsAcrossBothMethods) {
  const PbmCase c = stiff_case();
  const Ended fine = run(c, 1e-8);

  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    const Ended some = run(c, tolerance);
    EXPECT_LT(l1(some.state.number, fine.state.number), 5.0 * tolerance);
    const Drift d = drift(some.state, ClassGrid(c.grid));
    for (const double quantity : {d.solid_1, d.solid_2, d.liquid, d.gas}) EXPECT_LT(quantity, 1e-12);
    for (const auto* field : {&some.state.number, &some.state.liquid, &some.state.gas})
      EXPECT_GE(*std::min_element(field->begin(), field->end()), 0.0);
  }
}

TEST(Integrator, GoesOnWithTheSameBitsBetweenExplicitAndImplicitSteps) {
  // Half way the collisions have built what breaks fast: steps change from one method to the other.
  PbmCase c = stiff_case();
  c.initial = {{0, 0, 0, 100.0, 10.0, 10.0}};
  c.aggregation->rate = 0.5;
  c.end_time = 0.4, c.output_every = 0.1;
  Alone alone(1);
  const ClassGrid grid(c.grid);
  Simulation whole(c, initial_snapshot(c, grid), alone, 1);
  std::vector<Snapshot> at{initial_snapshot(c, grid)};
  for (int n = 1; n <= 4; ++n) {
    ASSERT_TRUE(whole.advance(0.1 * n));
    at.push_back(whole.snapshot());
  }
  ASSERT_GT(whole.work().implicit_steps, 0);
  ASSERT_LT(whole.work().implicit_steps, whole.work().steps);

  for (std::size_t n = 0; n < 4; ++n) {
    Simulation part(c, at[n], alone, 1);
    ASSERT_TRUE(part.advance(at[n + 1].time));
    EXPECT_EQ(part.snapshot().number, at[n + 1].number) << n;
    EXPECT_EQ(part.snapshot().ledger, at[n + 1].ledger) << n;
    EXPECT_EQ(part.snapshot().next_step, at[n + 1].next_step) << n;
  }
}

}  // namespace
}  // namespace granary::pbm
