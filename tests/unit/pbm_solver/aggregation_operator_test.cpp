// Every form of the aggregation operator against the plain double loop over pairs.
#include "pbm_solver/model/aggregation_operator.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "pbm_solver/model/compartment_block.hpp"
#include "tests/support/pbm_cases.hpp"

namespace granary::pbm {
namespace {

using Method = Aggregation::Method;
using Form = AggregationTables::Form;

/// What aggregation does in one block: births by class and moment, deaths per particle, what lands above the grid.
struct Sums {
  std::vector<double> births;  ///< [class][5][lane]
  std::vector<double> death;   ///< [class][lane]
  std::vector<double> above;   ///< [5][lane]
};

struct LaneState {
  LaneVector number, liquid, gas;
};

LaneState any_state(const ModelTables& tables, unsigned seed, double decades) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> one(0.0, 1.0);
  const auto lanes = static_cast<std::size_t>(tables.lanes), n = tables.grid.size() * lanes;
  LaneState s{LaneVector(n), LaneVector(n), LaneVector(n)};
  for (std::size_t k = 0; k < n; ++k) {
    if (k % lanes >= static_cast<std::size_t>(tables.pbm_case.compartments.count)) continue;
    const double number = one(random) < 0.2 ? 0.0 : std::pow(10.0, decades * one(random));
    s.number[k] = number;
    s.liquid[k] = number * tables.solids.solid[k] * one(random);
    s.gas[k] = number * tables.solids.solid[k] * one(random);
  }
  return s;
}

/// The plain double loop: every unordered pair once, half for a class with itself, with the pair kernel's beta.
Sums plain_sums(const ModelTables& tables, const ParticleTable& particles, const LaneState& s) {
  const PbmCase& c = tables.pbm_case;
  const ClassGrid& grid = tables.grid;
  const auto lanes = static_cast<std::size_t>(tables.lanes), n = grid.size();
  PairKernel kernel(c, grid, 0, c.compartments.count, tables.lanes);
  kernel.look_at(particles);
  Sums sums{std::vector<double>(n * 5 * lanes), std::vector<double>(n * lanes), std::vector<double>(5 * lanes)};
  std::vector<double> beta(n * lanes);
  const int n2 = grid.axis(1).size();
  const bool by_group = tables.aggregation->n_groups > 1;
  for (std::size_t k = 0; k < n; ++k) {
    kernel.row(particles, static_cast<int>(k), 0, static_cast<int>(n), beta.data());
    for (std::size_t m = 0; m <= k; ++m)
      for (std::size_t l = 0; l < lanes; ++l) {
        double b = beta[m * lanes + l];
        if (by_group) {
          const auto a = static_cast<std::size_t>(tables.aggregation->group[k]),
                     g = static_cast<std::size_t>(tables.aggregation->group[m]);
          b = kernel.scale()[l] * c.aggregation->efficiency.value * c.dem->collision_rate[a][g];
          if (c.aggregation->efficiency.model == Efficiency::Model::wet) {
            const double least = c.aggregation->efficiency.least_liquid_fraction;
            if (particles.liquid_fraction[k * lanes + l] < least || particles.liquid_fraction[m * lanes + l] < least)
              b = 0.0;
          }
        }
        const std::size_t p = k * lanes + l, q = m * lanes + l;
        const double half = k == m ? 0.5 : 1.0;
        const int ik = static_cast<int>(k) / n2, jk = static_cast<int>(k) % n2, im = static_cast<int>(m) / n2,
                  jm = static_cast<int>(m) % n2;
        const int i = grid.axis(0).sum_cell(ik, im), j = grid.axis(1).sum_cell(jk, jm);
        const double born = half * b * s.number[p] * s.number[q];
        const std::array<double, 5> moments{born, born * (grid.solid_1()[k] + grid.solid_1()[m]),
                                            born * (grid.solid_2()[k] + grid.solid_2()[m]),
                                            half * b * (s.liquid[p] * s.number[q] + s.number[p] * s.liquid[q]),
                                            half * b * (s.gas[p] * s.number[q] + s.number[p] * s.gas[q])};
        const bool leaves = i >= grid.axis(0).size() || j >= n2;
        for (std::size_t moment = 0; moment < 5; ++moment)
          (leaves ? sums.above[moment * lanes + l] : sums.births[(grid.index(i, j) * 5 + moment) * lanes + l]) +=
              moments[moment];
        sums.death[p] += half * b * s.number[q];
        sums.death[q] += half * b * s.number[p];
      }
  }
  return sums;
}

struct Operated {
  Sums sums;
  Form form;
  std::size_t rank;
};

Operated operate(const ModelTables& tables, ParticleTable& particles, const LaneState& s) {
  const PbmCase& c = tables.pbm_case;
  const auto lanes = static_cast<std::size_t>(tables.lanes), n = tables.grid.size();
  AggregationOperator aggregation(*tables.aggregation, c, tables.grid, tables.view, 0, c.compartments.count,
                                  tables.lanes);
  if (aggregation.looks_at_particles()) aggregation.refresh(particles);
  if (c.aggregation->efficiency.model == Efficiency::Model::wet)
    aggregation.set_wet(particles.wet(c.aggregation->efficiency.least_liquid_fraction));
  const auto stride = static_cast<std::size_t>(moment_stride(tables.lanes));
  LaneVector births(n * stride), rates(3 * n * lanes), loss(n * lanes), above(stride);
  aggregation.add({s.number.data(), s.liquid.data(), s.gas.data()}, nullptr, births.data(),
                  {rates.data(), rates.data() + n * lanes, rates.data() + 2 * n * lanes}, loss.data(), above.data());
  Operated out{{{}, {loss.begin(), loss.end()}, {above.begin(), above.begin() + static_cast<long>(5 * lanes)}},
               tables.aggregation->form,
               aggregation.rank()};
  for (std::size_t k = 0; k < n; ++k)
    out.sums.births.insert(out.sums.births.end(), births.begin() + static_cast<long>(k * stride),
                           births.begin() + static_cast<long>(k * stride + 5 * lanes));
  for (std::size_t k = 0; k < n * lanes; ++k) {
    const double scale = std::abs(loss[k] * s.number[k]);
    EXPECT_NEAR(rates[k], -loss[k] * s.number[k], 1e-13 * scale);
  }
  return out;
}

void expect_equal_element_by_element(const std::vector<double>& a, const std::vector<double>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double error = std::abs(a[k] - b[k]);
    ASSERT_LE(error, 1e-13 * std::abs(b[k])) << what << " " << k << ": " << a[k] << " for " << b[k];
  }
}

void expect_equal(const Sums& a, const Sums& b) {
  expect_equal_element_by_element(a.births, b.births, "birth");
  expect_equal_element_by_element(a.death, b.death, "death");
  expect_equal_element_by_element(a.above, b.above, "above the grid");
}

PbmCase any_case(int kernel, int n_compartments) {
  PbmCase c = testing::a_granulator(8, n_compartments);
  c.feed.reset(), c.spray.reset(), c.breakage.reset(), c.consolidation.reset(), c.compartments.residence_time.reset();
  const double ratio = *rc::gen::element(1.13, 1.1892071150027210667, 1.4142135623730951, 1.7, 2.0, 3.0, 9.0);
  const double other = *rc::gen::element(1.2, 1.2599210498948731648, 2.0, 2.6);
  c.grid.bins = {*rc::gen::inRange(1, 14), *rc::gen::inRange(2, 14)};
  c.grid.ratio = {ratio, other};
  c.grid.smallest = {5e-16, 5e-16 * *rc::gen::element(0.01, 1.0, 7.0)};
  if (c.grid.bins[0] == 1) c.grid.smallest[0] = 0.0;
  c.aggregation->kernel = static_cast<Aggregation::Kernel>(kernel);
  c.aggregation->efficiency.value = 0.7;
  c.reference_volume = 1e-12;
  for (auto& row : c.dem->collision_rate)
    for (double& rate : row) rate *= 1.0;
  for (std::size_t p = 0; p < c.dem->diameter.size(); ++p)
    for (std::size_t q = 0; q <= p; ++q)
      c.dem->collision_rate[p][q] = c.dem->collision_rate[q][p] *= 1.0 + 0.3 * static_cast<double>((3 * p + q) % 5);
  for (int x = 0; x < n_compartments; ++x) c.dem->compartment_factor.push_back(1.0 + 0.25 * x);
  return c;
}

void equals_the_double_loop(const PbmCase& c, unsigned seed, Form expected) {
  const ModelTables tables(c);
  const LaneState s = any_state(tables, seed, 6.0);
  ParticleTable particles(tables.solids, c.materials);
  particles.look_at(s.number.data(), s.liquid.data(), s.gas.data());
  particles.remember();

  const Operated done = operate(tables, particles, s);

  ASSERT_EQ(done.form, expected);
  expect_equal(done.sums, plain_sums(tables, particles, s));
}

RC_GTEST_PROP(AggregationOperator, OfGroupsEqualsTheDoubleLoopElementByElement, (unsigned seed)) {
  PbmCase c = any_case(*rc::gen::element(0, 4), *rc::gen::element(1, 8));
  c.aggregation->lookup = Aggregation::Lookup::group;
  c.aggregation->efficiency.model = *rc::gen::element(Efficiency::Model::constant, Efficiency::Model::wet);
  equals_the_double_loop(c, seed, Form::groups);
}

RC_GTEST_PROP(AggregationOperator, OfFactorsEqualsTheDoubleLoopElementByElement, (unsigned seed)) {
  PbmCase c = any_case(*rc::gen::inRange(1, 4), *rc::gen::element(1, 5));
  c.aggregation->efficiency.model = *rc::gen::element(Efficiency::Model::constant, Efficiency::Model::wet);
  equals_the_double_loop(c, seed, Form::factors);
}

RC_GTEST_PROP(AggregationOperator, OfPairsEqualsTheDoubleLoopElementByElement, (unsigned seed)) {
  PbmCase c = any_case(*rc::gen::inRange(0, 5), *rc::gen::element(1, 8));
  c.aggregation->method = Method::pairs;
  c.aggregation->efficiency.model = static_cast<Efficiency::Model>(*rc::gen::inRange(0, 3));
  equals_the_double_loop(c, seed, Form::pairs);
}

/// Liquid and pores as they are in a granulator: between dry fines and wet granules, different in each compartment.
LaneState a_wetted_state(const ModelTables& tables) {
  LaneState s = any_state(tables, 5, 3.0);
  const auto lanes = static_cast<std::size_t>(tables.lanes);
  for (std::size_t k = 0; k < s.number.size(); ++k) {
    const double octaves = std::log2(tables.solids.solid[k] / tables.solids.solid[0]);
    const double wet = (0.05 + 0.03 * static_cast<double>(k % lanes)) * octaves / (3.0 + octaves);
    s.liquid[k] = s.number[k] * tables.solids.solid[k] * wet;
    s.gas[k] = s.number[k] * tables.solids.solid[k] * (0.5 - 0.2 * wet);
  }
  return s;
}

TEST(AggregationOperator, OfLowRankIsAsNearToTheKernelAsItsToleranceSaysForNearlyEveryPair) {
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    PbmCase c = testing::a_granulator(16, 8);
    c.aggregation->method = Method::low_rank;
    c.kernel_tolerance = tolerance;
    const ModelTables tables(c);
    const LaneState s = a_wetted_state(tables);
    ParticleTable particles(tables.solids, c.materials);
    particles.look_at(s.number.data(), s.liquid.data(), s.gas.data());
    particles.remember();
    for (std::size_t l = 0; l < 8; ++l) {
      const ParticleTable one = particles.lane(l, 8);
      PairKernel kernel(c, tables.grid, static_cast<int>(l), 1, 1);
      kernel.look_at(one);
      const std::size_t n = tables.grid.size();

      const CrossApproximation a = approximate(kernel, one, n, tolerance, 60);

      EXPECT_TRUE(a.converged);
      EXPECT_LT(a.plus.size() + a.minus.size(), 40u);
      std::vector<double> beta(n), collisions(n);
      double worst = 0.0;
      std::size_t beyond = 0;
      for (std::size_t k = 0; k < n; ++k) {
        kernel.row(one, static_cast<int>(k), 0, static_cast<int>(n), beta.data());
        kernel.collisions(one, static_cast<int>(k), 0, static_cast<int>(n), collisions.data());
        for (std::size_t m = 0; m < n; ++m) {
          double near = 0.0;
          for (const auto& u : a.plus) near += u[k] * u[m];
          for (const auto& v : a.minus) near -= v[k] * v[m];
          const double error = std::abs(near - beta[m]) / collisions[m];
          worst = std::max(worst, error);
          if (error > 2.0 * tolerance) ++beyond;
        }
      }
      // Twice the tolerance for the lift to what is not negative. Pairs nobody looked at can be worse: where the mean
      // film is just the asperity's height the efficiency has a kink.
      EXPECT_LT(static_cast<double>(beyond), 1e-3 * static_cast<double>(n * n));
      EXPECT_LT(worst, std::max(0.03, 4.0 * tolerance)) << "rank " << a.plus.size() + a.minus.size();
    }
  }
}

TEST(AggregationOperator, ChoosesTheFormByKernelEfficiencyAndSize) {
  PbmCase c = testing::a_granulator(16, 16);
  EXPECT_EQ(AggregationTables(c, ClassGrid(c.grid)).form, Form::pairs);
  c.grid.bins = {80, 80};
  c.grid.ratio = {1.3, 1.3};
  EXPECT_EQ(AggregationTables(c, ClassGrid(c.grid)).form, Form::low_rank);
  c.kernel_tolerance = 0.0;
  EXPECT_EQ(AggregationTables(c, ClassGrid(c.grid)).form, Form::pairs);
  c.aggregation->efficiency.model = Efficiency::Model::wet;
  c.aggregation->lookup = Aggregation::Lookup::group;
  EXPECT_EQ(AggregationTables(c, ClassGrid(c.grid)).form, Form::groups);
  c.aggregation->kernel = Aggregation::Kernel::shear;
  EXPECT_EQ(AggregationTables(c, ClassGrid(c.grid)).form, Form::factors);
}

TEST(BirthPlan, HasTheProductsOfItsTheoryNotThePairs) {
  // 16, 32 and 64 classes an axis over 16 octaves: 1520, 14060, 157271 products for 8 groups against N^4 / 2 pairs.
  const std::array<long, 3> known{1520, 14060, 157271};
  for (int m = 0; m < 3; ++m) {
    PbmCase c = testing::a_case(16 << m);
    c.grid.ratio = {std::exp2(1.0 / (1 << m)), std::exp2(1.0 / (1 << m))};
    const ClassGrid grid(c.grid);
    std::vector<int> group;
    const double octaves = std::log2(grid.solid().back() / grid.solid().front());
    for (const double s : grid.solid())
      group.push_back(std::min(7, static_cast<int>(8.0 * std::log2(s / grid.solid().front()) / octaves)));

    const BirthPlan plan(grid, group, 8);

    EXPECT_LT(static_cast<double>(plan.products()), 1.2 * static_cast<double>(known[static_cast<std::size_t>(m)]));
  }
}

}  // namespace
}  // namespace granary::pbm
