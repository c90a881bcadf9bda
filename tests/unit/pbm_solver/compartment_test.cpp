// The rates of a block of compartments: every mechanism's balance closes, whatever the state.
#include "pbm_solver/model/compartment_block.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "pbm_solver/verification/cell_average.hpp"
#include "tests/support/pbm_cases.hpp"

namespace granary::pbm {
namespace {

struct State {
  std::vector<double> number, liquid, gas;
  Fields fields() const { return {number, liquid, gas}; }
};

/// Every class filled over ten decades, or left empty.
State any_state(const ClassGrid& grid, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> one(0.0, 1.0);
  State s;
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const double number = one(random) < 0.2 ? 0.0 : std::pow(10.0, 10 * one(random));
    s.number.push_back(number);
    s.liquid.push_back(number * grid.solid()[k] * one(random));
    s.gas.push_back(number * grid.solid()[k] * one(random));
  }
  return s;
}

struct Rates {
  std::vector<double> number, liquid, gas, flows;
};

/// Of compartment `index`, which is in its own lane; the others are empty.
Rates rates_of(const ModelTables& tables, Fields state, Inputs inputs = {}, int index = 0,
               std::span<const double> participation = {}) {
  const std::size_t n = tables.grid.size(), lanes = static_cast<std::size_t>(tables.lanes);
  const int first = index / tables.lanes * tables.lanes, count = tables.pbm_case.compartments.count - first;
  const auto lane = static_cast<std::size_t>(index - first);
  CompartmentBlock block(tables, first, std::min(count, tables.lanes));
  LaneVector packed(block.stride()), rates(block.stride()), part;
  for (std::size_t k = 0; k < n; ++k) {
    packed[k * lanes + lane] = state.number[k];
    packed[(n + k) * lanes + lane] = state.liquid[k];
    packed[(2 * n + k) * lanes + lane] = state.gas[k];
  }
  if (!participation.empty()) {
    part.assign(n * lanes, 1.0);
    for (std::size_t k = 0; k < n; ++k) part[k * lanes + lane] = participation[k];
  }
  block.look_at_particles(packed.data());
  block.begin_step(packed.data());
  block.rates(packed.data(), part.empty() ? nullptr : part.data(), nullptr, inputs, true, rates.data());
  Rates r;
  const auto take = [&](std::size_t from, std::size_t count_of) {
    std::vector<double> list;
    for (std::size_t e = from; e < from + count_of; ++e) list.push_back(rates[e * lanes + lane]);
    return list;
  };
  r.number = take(0, n), r.liquid = take(n, n), r.gas = take(2 * n, n), r.flows = take(3 * n, ledger::kSize);
  return r;
}

/// |d(held)/dt - in + out + oversize + consolidated| over the sum of all |terms|, for each conserved quantity.
std::array<double, 4> imbalance(const ClassGrid& grid, const Rates& r) {
  std::array<double, 4> sum{}, size{};
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const double terms[] = {r.number[k] * grid.solid_1()[k], r.number[k] * grid.solid_2()[k], r.liquid[k], r.gas[k]};
    for (std::size_t q = 0; q < 4; ++q) sum[q] += terms[q], size[q] += std::abs(terms[q]);
  }
  for (std::size_t q = 0; q < 4; ++q) {
    sum[q] += r.flows[ledger::kOut + q] + r.flows[ledger::kOversize + q] - r.flows[ledger::kIn + q];
    size[q] += r.flows[ledger::kOut + q] + r.flows[ledger::kOversize + q] + r.flows[ledger::kIn + q];
  }
  sum[3] += r.flows[ledger::kConsolidated];
  for (std::size_t q = 0; q < 4; ++q) sum[q] = size[q] > 0 ? std::abs(sum[q]) / size[q] : 0.0;
  return sum;
}

RC_GTEST_PROP(Compartment, ClosesEveryBalanceWithAllMechanismsOn, (unsigned seed)) {
  PbmCase c = testing::a_granulator(9, 1);
  c.aggregation->efficiency.model = static_cast<Efficiency::Model>(*rc::gen::inRange(0, 3));
  c.breakage->daughters = static_cast<Breakage::Daughters>(*rc::gen::inRange(0, 3));
  c.materials.saturation_factor = *rc::gen::inRange(0, 3) * 0.5;
  const ModelTables tables(c);
  const State s = any_state(tables.grid, seed);

  const Rates r = rates_of(tables, s.fields(), {true, true});

  for (const double error : imbalance(tables.grid, r)) RC_ASSERT(error < 1e-13);
}

RC_GTEST_PROP(Compartment, ClosesEveryBalanceForEveryKernel, (unsigned seed)) {
  PbmCase c = testing::a_case(7);
  c.aggregation = Aggregation{};
  c.aggregation->kernel = static_cast<Aggregation::Kernel>(*rc::gen::inRange(0, 4));
  const ModelTables tables(c);
  const State s = any_state(tables.grid, seed);

  for (const double error : imbalance(tables.grid, rates_of(tables, s.fields()))) RC_ASSERT(error < 1e-13);
}

TEST(Aggregation, TakesOneParticleAPairFromTheNumber) {
  // d(number)/dt + oversize = -1/2 sum over ordered pairs of beta F F', plus what oversize takes: two particles become
  // one.
  PbmCase c = testing::a_case(6);
  c.aggregation = Aggregation{};
  c.aggregation->rate = 0.5;
  const ModelTables tables(c);
  const State s = any_state(tables.grid, 4);
  double total = 0.0;
  for (const double n : s.number) total += n;

  const Rates r = rates_of(tables, s.fields());

  double rate = r.flows[ledger::kOversizeNumber];
  for (const double n : r.number) rate += n;
  EXPECT_NEAR(rate / (-0.5 * 0.5 * total * total), 1.0, 1e-12);
}

TEST(Aggregation, IsTheDirectSumOverOrderedPairs) {
  // An independent evaluation: every ordered pair with weight 1/2, its product looked up by volume.
  PbmCase c = testing::a_case(5);
  c.aggregation = Aggregation{};
  c.aggregation->kernel = Aggregation::Kernel::sum;
  const ModelTables tables(c);
  const ClassGrid& grid = tables.grid;
  const State s = any_state(grid, 11);
  BirthGrid births(grid);
  std::vector<double> number(grid.size()), liquid(grid.size()), gas(grid.size());
  for (std::size_t k = 0; k < grid.size(); ++k)
    for (std::size_t m = 0; m < grid.size(); ++m) {
      const double beta = grid.solid()[k] + grid.solid()[m];
      const double s1 = grid.solid_1()[k] + grid.solid_1()[m], s2 = grid.solid_2()[k] + grid.solid_2()[m];
      const double half = 0.5 * beta * s.number[k] * s.number[m];
      births.at(grid.axis(0).cell(s1), grid.axis(1).cell(s2)) +=
          {half, half * s1, half * s2, 0.5 * beta * (s.liquid[k] * s.number[m] + s.number[k] * s.liquid[m]),
           0.5 * beta * (s.gas[k] * s.number[m] + s.number[k] * s.gas[m])};
      number[k] -= beta * s.number[k] * s.number[m];
      liquid[k] -= beta * s.liquid[k] * s.number[m];
      gas[k] -= beta * s.gas[k] * s.number[m];
    }
  share_births(grid, births, {number, liquid, gas});

  const Rates r = rates_of(tables, s.fields());

  double largest = 0.0;
  for (const double n : number) largest = std::max(largest, std::abs(n));
  for (std::size_t k = 0; k < grid.size(); ++k) {
    EXPECT_NEAR(r.number[k], number[k], 1e-12 * largest);
    EXPECT_NEAR(r.liquid[k] / grid.solid()[k], liquid[k] / grid.solid()[k], 1e-12 * largest);
    EXPECT_NEAR(r.gas[k] / grid.solid()[k], gas[k] / grid.solid()[k], 1e-12 * largest);
  }
}

TEST(Compartment, TreatsBothSolidsAlike) {
  PbmCase c = testing::a_granulator(8, 1);
  const ModelTables tables(c);
  const ClassGrid& grid = tables.grid;
  const State s = any_state(grid, 5);
  State mirrored = s;
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) {
      mirrored.number[grid.index(i, j)] = s.number[grid.index(j, i)];
      mirrored.liquid[grid.index(i, j)] = s.liquid[grid.index(j, i)];
      mirrored.gas[grid.index(i, j)] = s.gas[grid.index(j, i)];
    }

  const Rates a = rates_of(tables, s.fields()), b = rates_of(tables, mirrored.fields());

  double largest = 0.0;
  for (const double n : a.number) largest = std::max(largest, std::abs(n));
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) EXPECT_NEAR(a.number[grid.index(i, j)], b.number[grid.index(j, i)], 1e-13 * largest);
}

TEST(Compartment, KeepsOneLiquidContentAndPorosityUniform) {
  // Aggregation and breakage mix; where all granules are alike there is nothing to mix.
  PbmCase c = testing::a_granulator(8, 1);
  c.consolidation.reset();
  const ModelTables tables(c);
  State s = any_state(tables.grid, 6);
  for (std::size_t k = 0; k < s.number.size(); ++k) {
    s.liquid[k] = 0.3 * tables.grid.solid()[k] * s.number[k];
    s.gas[k] = 0.8 * tables.grid.solid()[k] * s.number[k];
  }

  const Rates r = rates_of(tables, s.fields());

  double largest = 0.0;
  for (const double l : r.liquid) largest = std::max(largest, std::abs(l));
  for (std::size_t k = 0; k < s.number.size(); ++k) {
    EXPECT_NEAR(r.liquid[k], 0.3 * tables.grid.solid()[k] * r.number[k], 1e-12 * largest);
    EXPECT_NEAR(r.gas[k], 0.8 * tables.grid.solid()[k] * r.number[k], 1e-12 * largest);
  }
}

TEST(Compartment, AddsLiquidInProportionToSolid) {
  PbmCase c = testing::a_case(4);
  c.spray = Spray{2.0, 0, 0.0, 1e300};
  const ModelTables tables(c);
  const State s = any_state(tables.grid, 7);
  double solid = 0.0;
  for (std::size_t k = 0; k < s.number.size(); ++k) solid += tables.grid.solid()[k] * s.number[k];

  const Rates r = rates_of(tables, s.fields(), {false, true});

  for (std::size_t k = 0; k < s.number.size(); ++k)
    EXPECT_NEAR(r.liquid[k], 2.0 * tables.grid.solid()[k] * s.number[k] / solid, 1e-14);
  EXPECT_EQ(r.flows[ledger::kIn + 2], 2.0);
}

TEST(Compartment, SlowsAClassDownByItsParticipationWithoutLosingAnything) {
  PbmCase c = testing::a_granulator(8, 1);
  const ModelTables tables(c);
  const State s = any_state(tables.grid, 8);
  std::vector<double> participation(tables.grid.size(), 1.0);
  for (std::size_t k = 0; k < participation.size(); k += 3) participation[k] = 0.01;

  const Rates r = rates_of(tables, s.fields(), {}, 0, participation);

  for (const double error : imbalance(tables.grid, r)) EXPECT_LT(error, 1e-13);
}

TEST(Compartment, DoesNothingWithoutMechanisms) {
  const ModelTables tables(testing::a_case(4));
  const State s = any_state(tables.grid, 9);

  const Rates r = rates_of(tables, s.fields());

  for (const auto* list : {&r.number, &r.liquid, &r.gas, &r.flows})
    for (const double rate : *list) EXPECT_EQ(rate, 0.0);
}

}  // namespace
}  // namespace granary::pbm
