// The bench: the plain reference solves the same equations as the solver, so comparing their times is fair.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/math/percentile.hpp"
#include "pbm_solver/bench/bench_cases.hpp"
#include "pbm_solver/bench/class_table.hpp"
#include "pbm_solver/bench/cost_front.hpp"
#include "pbm_solver/bench/measure.hpp"
#include "pbm_solver/bench/rates_timer.hpp"
#include "pbm_solver/bench/reference_solver.hpp"
#include "pbm_solver/bench/solver_run.hpp"

namespace granary::pbm::bench {
namespace {

/// Scale of round-off in each element: |rate| + twice the loss there, added up over it and its neighbours on the grid,
/// since births near a pivot are shared out by differences of volumes.
std::vector<double> round_off_scale(const BenchCase& b, const std::vector<double>& rate,
                                    const std::vector<double>& content) {
  const ClassGrid grid(b.pbm_case.grid);
  const ClassTable table = class_table_of(b.pbm_case, grid);
  const int rows = grid.axis(0).size(), columns = grid.axis(1).size();
  std::vector<double> scale(content.size());
  for (std::size_t at = 0; at < content.size(); ++at) {
    const std::size_t first = at / grid.size() * grid.size(), k = at - first;
    double loss = 0.0;
    for (std::size_t m = 0; m < grid.size(); ++m)
      loss += table.scale[first / grid.size()] * table.rate[table.class_of[k] * table.size + table.class_of[m]] *
              b.start.number[first + m];
    const double mine = std::abs(rate[at]) + 2.0 * loss * content[at];
    const int row = static_cast<int>(k) / columns, column = static_cast<int>(k) % columns;
    for (int i = std::max(0, row - 1); i <= std::min(rows - 1, row + 1); ++i)
      for (int j = std::max(0, column - 1); j <= std::min(columns - 1, column + 1); ++j)
        scale[first + grid.index(i, j)] += mine;
  }
  return scale;
}

/// Contents over 12 decades, some classes empty.
void randomize(BenchCase& b, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> decade(-6.0, 6.0), share(0.0, 1.0);
  const ClassGrid grid(b.pbm_case.grid);
  for (std::size_t at = 0; at < b.start.number.size(); ++at) {
    const double number = share(random) < 0.1 ? 0.0 : std::pow(10.0, decade(random));
    b.start.number[at] = number;
    b.start.liquid[at] = number * grid.solid()[at % grid.size()] * share(random);
    b.start.gas[at] = number * grid.solid()[at % grid.size()] * share(random);
  }
}

void expect_same_rates(const BenchCase& b) {
  Alone alone(b.pbm_case.compartments.count);
  SolverRates solver(b.pbm_case, b.start, alone, 1);
  solver.evaluate();
  const ReferenceState ours = solver.rates();
  ReferenceSolver scanning(b.pbm_case, CellSearch::scan), bisecting(b.pbm_case, CellSearch::bisection);
  ReferenceState theirs = reference_state(b.start), found_by_bisection = theirs;
  scanning.rates(reference_state(b.start), theirs);
  bisecting.rates(reference_state(b.start), found_by_bisection);
  EXPECT_EQ(theirs.number, found_by_bisection.number);
  EXPECT_EQ(theirs.liquid, found_by_bisection.liquid);

  const auto compare = [&](const char* what, const std::vector<double>& a, const std::vector<double>& c,
                           const std::vector<double>& content) {
    const std::vector<double> scale = round_off_scale(b, c, content);
    ASSERT_EQ(c.size(), a.size());
    double most = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      ASSERT_LE(std::abs(a[k] - c[k]), 1e-12 * scale[k])
          << what << " of class " << k << ": " << a[k] << " and " << c[k];
      most = std::max(most, scale[k]);
    }
    EXPECT_TRUE(most > 0.0 || content == std::vector<double>(content.size())) << "nothing happens to " << what;
  };
  compare("number", ours.number, theirs.number, b.start.number);
  compare("liquid", ours.liquid, theirs.liquid, b.start.liquid);
  compare("gas", ours.gas, theirs.gas, b.start.gas);
}

TEST(ReferenceSolver, HasTheRightHandSideOfTheSolverForTheConstantKernel) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    BenchCase b = operator_case(12, 3, KernelKind::constant, 1);
    randomize(b, seed);
    expect_same_rates(b);
  }
}

TEST(ReferenceSolver, HasTheRightHandSideOfTheSolverForTablesOfClasses) {
  for (const int bins : {10, 16})
    for (const int n_classes : {3, 8, 16}) {
      BenchCase b = operator_case(bins, 3, KernelKind::classes, n_classes);
      randomize(b, static_cast<unsigned>(bins + n_classes));
      expect_same_rates(b);
    }
}

TEST(ReferenceSolver, HasTheRightHandSideOfTheSolverOnTheGridsOfTheBench) {
  expect_same_rates(operator_case(32, 1, KernelKind::classes, 8));
  expect_same_rates(aggregation_case(32, 1e-3));
}

TEST(ReferenceSolver, RunsToTheSolutionOfTheSolverWithTheFirstOrderOfItsSteps) {
  const BenchCase b = aggregation_case(8, 1e-6);
  const auto ours = run_solver(b, 60.0);
  ASSERT_TRUE(ours && ours->finished);
  const auto error_at = [&](double limit) {
    ReferenceSolver reference(b.pbm_case);
    ReferenceState state = reference_state(b.start);
    const EulerRun run = run_euler(reference, state, b.pbm_case.end_time, limit, 60.0);
    EXPECT_TRUE(run.finished);
    return l1_difference(state.number, ours->end.number);
  };

  const double coarse = error_at(0.02), fine = error_at(0.005);

  EXPECT_LT(fine, 4e-3);
  EXPECT_NEAR(std::log(coarse / fine) / std::log(4.0), 1.0, 0.15);
}

TEST(ReferenceSolver, StopsWhenItsBudgetIsUsedUp) {
  const BenchCase b = aggregation_case(16, 1e-3);
  ReferenceSolver reference(b.pbm_case);
  ReferenceState state = reference_state(b.start);

  const EulerRun run = run_euler(reference, state, b.pbm_case.end_time, 1e-4, 0.01);

  EXPECT_FALSE(run.finished);
  EXPECT_GT(run.steps, 0);
}

TEST(CostAtError, LiesOnStraightLinesInLogarithms) {
  const std::vector<CostPoint> runs{{1.0, 0.1}, {100.0, 0.001}, {50.0, 0.2}};  // the last is beaten by the first

  EXPECT_NEAR(cost_at_error(runs, 0.01).cost, 10.0, 1e-12);
  EXPECT_TRUE(cost_at_error(runs, 0.01).reached);
  EXPECT_NEAR(cost_at_error(runs, 0.001).cost, 100.0, 1e-9);
}

TEST(CostAtError, NeverExtrapolates) {
  const std::vector<CostPoint> runs{{1.0, 0.1}, {100.0, 0.001}};

  EXPECT_EQ(cost_at_error(runs, 0.5).cost, 1.0) << "the cheapest run is accurate enough";
  EXPECT_EQ(cost_at_error(runs, 0.0005).cost, 100.0);
  EXPECT_FALSE(cost_at_error(runs, 0.0005).reached);
}

TEST(Percentile, LiesBetweenTheNeighboursInOrder) {
  EXPECT_EQ(percentile({3.0, 1.0, 2.0}, 0.5), 2.0);
  EXPECT_DOUBLE_EQ(percentile({4.0, 1.0, 2.0, 3.0, 5.0}, 0.1), 1.4);
  EXPECT_EQ(percentile({}, 0.5), 0.0);
}

TEST(TimeInTurn, EvaluatesSlowContendersOnceAndFastOnesOften) {
  int slow = 0, fast = 0;
  const auto spin = [](double seconds) {
    for (const double began = thread_cpu(); thread_cpu() - began < seconds;) {
    }
  };

  const auto timings = time_in_turn({{[&] { ++slow, spin(0.02); }, 0.01}, {[&] { ++fast, spin(1e-4); }}}, 5, 1e-3);

  EXPECT_EQ(slow, 1);
  EXPECT_EQ(timings[0].rounds, 1);
  EXPECT_GE(timings[0].seconds, 0.02);
  EXPECT_GT(fast, 5);
  EXPECT_EQ(timings[1].rounds, 5);
  EXPECT_GE(timings[1].seconds, 1e-4);
}

}  // namespace
}  // namespace granary::pbm::bench
