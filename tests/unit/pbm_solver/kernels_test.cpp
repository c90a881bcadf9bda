// Aggregation kernels, collision efficiency, selection function, consolidation: formulas against independent
// evaluations.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/units.hpp"
#include "pbm_solver/model/consolidation.hpp"
#include "pbm_solver/model/pair_kernel.hpp"
#include "pbm_solver/model/selection_function.hpp"
#include "tests/support/pbm_cases.hpp"

namespace granary::pbm {
namespace {

/// Integral of a function by the midpoint rule: independent of erfc.
double integral(const std::function<double(double)>& f, double from, double to, int n = 20000) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += f(from + (to - from) * (i + 0.5) / n);
  return sum * (to - from) / n;
}

double log_normal_density(const SpeedDistribution& s, double speed) {
  const double z = (std::log(speed) - s.ln_mean) / s.ln_sigma;
  return std::exp(-0.5 * z * z) / (speed * s.ln_sigma * std::sqrt(2.0 * kPi));
}

/// psi of two particles through the vectorised row.
double sticking_share(const StokesCriterion& c, double d_p, double m_p, double h_p, double d_q, double m_q,
                      double h_q) {
  const double inverse_d[] = {1 / d_q, 1 / d_p}, inverse_m[] = {1 / m_q, 1 / m_p}, film[] = {h_q, h_p};
  double beta[] = {1.0, 1.0};
  multiply_by_sticking_share(c, {inverse_d, inverse_m, film}, 1, 0, 2, 1, beta);
  return beta[0];
}

TEST(CollisionEfficiency, IsTheShareOfSpeedsBelowTheCriticalOne) {
  Efficiency e;
  e.restitution = 0.2;
  e.asperity = 5e-6;
  Materials materials;
  const SpeedDistribution speeds{0.3, 0.7};
  const double d_p = 5e-4, d_q = 8e-4, m_p = 1000 * kPi / 6 * d_p * d_p * d_p, m_q = 1000 * kPi / 6 * d_q * d_q * d_q;
  const double h_p = 4e-5, h_q = 2e-5;
  const double d = 2 * d_p * d_q / (d_p + d_q), m = 2 * m_p * m_q / (m_p + m_q), h = 0.5 * (h_p + h_q);
  const double critical = 3 * kPi * d * d * 0.05 / (8 * m) * (1 + 1 / 0.2) * std::log(h / 5e-6);

  const double share = sticking_share(stokes_criterion(e, materials, speeds), d_p, m_p, h_p, d_q, m_q, h_q);

  ASSERT_GT(critical, 0.1);
  EXPECT_NEAR(share, integral([&](double u) { return log_normal_density(speeds, u); }, 1e-9, critical), 1e-6);
}

TEST(CollisionEfficiency, HasTheCriticalSpeedOfThePublishedExample) {
  // mu 0.05 Pa s, e 0.2, h/h_a 10, density 476: 33, 6.5 and 3.3 m/s for 0.1, 0.5 and 1 mm. psi = 1/2 where ln U_crit is
  // the mean.
  for (const auto& [diameter, speed] : {std::pair{1e-4, 33.0}, {5e-4, 6.5}, {1e-3, 3.3}}) {
    Efficiency e;
    const double m = 476 * kPi / 6 * diameter * diameter * diameter, film = 10 * e.asperity;
    const auto share_at = [&](double mean_speed) {
      return sticking_share(stokes_criterion(e, Materials{}, {std::log(mean_speed), 0.1}), diameter, m, film, diameter,
                            m, film);
    };
    EXPECT_GT(share_at(0.96 * speed), 0.5);
    EXPECT_LT(share_at(1.04 * speed), 0.5);
  }
}

TEST(CollisionEfficiency, IsNoneWhenDryAndOneWhenThickAndSlow) {
  const StokesCriterion c{0.1, 5e-6, 0.0, 1.0};

  EXPECT_EQ(sticking_share(c, 1e-3, 1e-6, 0.0, 1e-3, 1e-6, 0.0), 0.0);
  EXPECT_EQ(sticking_share(c, 1e-3, 1e-6, 5e-6, 1e-3, 1e-6, 5e-6), 0.0);
  EXPECT_EQ(sticking_share({1e12, 5e-6, 0.0, 1.0}, 1e-3, 1e-6, 1e-4, 1e-3, 1e-6, 1e-4), 1.0);
}

TEST(CollisionEfficiency, GivesTheSameForEveryLengthOfTheRow) {
  const StokesCriterion c{0.02, 5e-6, 0.0, 1.0};
  std::vector<double> d(37), m(37), film(37);
  for (std::size_t q = 0; q < d.size(); ++q) {
    const double diameter = 1e-4 * std::pow(1.1, q);
    d[q] = 1 / diameter, m[q] = 1 / (500 * diameter * diameter * diameter),
    film[q] = 6e-6 + 1e-6 * static_cast<double>(q);
  }
  std::vector<double> whole(37, 2.0);
  multiply_by_sticking_share(c, {d.data(), m.data(), film.data()}, 5, 0, 37, 1, whole.data());

  for (std::size_t n = 1; n <= 37; ++n) {
    std::vector<double> part(n, 2.0);
    multiply_by_sticking_share(c, {d.data(), m.data(), film.data()}, 5, 0, n, 1, part.data());
    for (std::size_t q = 0; q < n; ++q) EXPECT_NEAR(part[q], whole[q], 1e-14);
  }
}

TEST(SelectionFunction, IsTheShareOfImpactsAboveTheBreakageSpeed) {
  const SpeedDistribution speeds{0.5, 0.8};
  for (const double speed : {0.1, 1.0, 2.1, 20.0})
    EXPECT_NEAR(share_faster(speeds, speed),
                integral([&](double u) { return log_normal_density(speeds, u); }, speed, 400.0, 200000), 2e-6);
}

TEST(SelectionFunction, HasTheBreakageSpeedOfTheDerivedFormula) {
  // With pi and eps^2: St* 0.2, eps 0.5, d_pp 12.4 um, mu 0.05: 2 St*/rho 9/8 9 pi mu / (16 d_pp).
  Breakage b;
  const double density = 1000.0;

  const double expected = 2 * 0.2 / density * 9.0 / 8.0 * 9 * kPi * 0.05 / (16 * 12.4e-6);

  EXPECT_NEAR(breakage_speed(b, 0.05, density, 0.5), expected, 1e-12 * expected);
  EXPECT_NEAR(breakage_speed(b, 0.05, density, 0.2), 16.0 * expected, 1e-11 * expected);
  EXPECT_TRUE(std::isinf(breakage_speed(b, 0.05, density, 0.0)));
}

TEST(SelectionFunction, OfATableIsLinearInTheLogarithmOfTheVolume) {
  PbmCase c = testing::a_granulator();
  c.breakage->selection = Breakage::Selection::table;
  c.breakage->rate = 2.0;
  c.breakage->table = {{1.0, 100.0, 1000.0}, {0.5, 4.5, 0.0}, {}};
  const SelectionFunction selection(c, 0);
  const ParticleTable none(SolidLanes(ClassGrid(c.grid), c.materials, 1), c.materials);  // nothing of it is looked at

  EXPECT_DOUBLE_EQ(selection(0.01, none, 0), 1.0);  // constant beyond
  EXPECT_DOUBLE_EQ(selection(1.0, none, 0), 1.0);
  EXPECT_DOUBLE_EQ(selection(10.0, none, 0), 5.0);  // half way in ln v: 2 (0.5 + 4.5) / 2
  EXPECT_DOUBLE_EQ(selection(100.0, none, 0), 9.0);
  EXPECT_DOUBLE_EQ(selection(1e6, none, 0), 0.0);
}

TEST(RateTable, GivesTheTableBackAtItsClassCentres) {
  const PbmCase c = testing::a_granulator();
  DemRates dem = *c.dem;
  for (std::size_t p = 0; p < dem.diameter.size(); ++p)
    for (std::size_t q = 0; q < dem.diameter.size(); ++q)
      dem.collision_rate[p][q] *= 1.0 + 0.1 * static_cast<double>(p * q % 7);
  const RateTable kernel(dem.diameter, dem.collision_rate, RateTable::Law::orthokinetic);

  for (std::size_t p = 0; p < dem.diameter.size(); ++p)
    for (std::size_t q = 0; q < dem.diameter.size(); ++q) {
      const double rate = dem.collision_rate[p][q];
      EXPECT_NEAR(kernel(dem.diameter[p], dem.diameter[q]), 0.5 * (rate + dem.collision_rate[q][p]), 1e-12 * rate);
    }
}

TEST(RateTable, IsSymmetricAndFollowsTheOrthokineticLawBeyondItsClasses) {
  DemRates dem;
  dem.diameter = {1e-4, 2e-4};
  dem.collision_rate = {{1e-12, 3e-12}, {3e-12, 5e-12}};
  const RateTable kernel(dem.diameter, dem.collision_rate, RateTable::Law::orthokinetic);

  EXPECT_DOUBLE_EQ(kernel(1.3e-4, 1.9e-4), kernel(1.9e-4, 1.3e-4));
  EXPECT_NEAR(kernel(1e-5, 1e-5) / 1e-12, 1e-3, 1e-12);  // ten times smaller: a thousandth
  EXPECT_NEAR(kernel(4e-4, 4e-4) / 5e-12, 8.0, 1e-11);
}

TEST(RateTable, TakesZerosAndASingleClass) {
  DemRates dem;
  dem.diameter = {1e-4};
  dem.collision_rate = {{0.0}};
  const auto kernel = [&] { return RateTable(dem.diameter, dem.collision_rate, RateTable::Law::orthokinetic); };
  EXPECT_EQ(kernel()(1e-4, 1e-3), 0.0);
  dem.collision_rate = {{8.0}};
  EXPECT_NEAR(kernel()(5e-5, 5e-5), 1.0, 1e-12);
}

TEST(RateTable, OfAUserIsFlatBeyondItsEnds) {
  const RateTable kernel({1e-4, 4e-4}, {{1.0, 3.0}, {3.0, 5.0}}, RateTable::Law::flat);

  EXPECT_DOUBLE_EQ(kernel(1e-5, 1e-5), 1.0);
  EXPECT_DOUBLE_EQ(kernel(1.0, 1e-5), 3.0);
  EXPECT_NEAR(kernel(2e-4, 2e-4), 3.0, 1e-12);  // the middle in ln d, both ways
}

TEST(PairKernel, RowAgreesWithTheKernelOfEachPairInEveryLane) {
  PbmCase c = testing::a_granulator(6, 8);
  c.aggregation->efficiency.model = Efficiency::Model::constant;
  c.aggregation->efficiency.value = 1.0;
  c.aggregation->rate = 3.0;
  for (int x = 0; x < 8; ++x) c.dem->compartment_factor.push_back(1.0 + x);
  const ClassGrid grid(c.grid);
  const SolidLanes solids(grid, c.materials, 8);
  ParticleTable particles(solids, c.materials);
  LaneVector number(grid.size() * 8, 10.0), liquid(number.size(), 1e-15), gas(number.size(), 2e-15);
  for (std::size_t k = 0; k < gas.size(); ++k) gas[k] *= static_cast<double>(k % 8);
  particles.look_at(number.data(), liquid.data(), gas.data());
  particles.remember();
  PairKernel kernel(c, grid, 0, 8, 8);
  kernel.look_at(particles);
  const RateTable table(c.dem->diameter, c.dem->collision_rate, RateTable::Law::orthokinetic);

  LaneVector beta(10 * 8);
  kernel.row(particles, 20, 5, 10, beta.data());

  for (std::size_t q = 0; q < 10; ++q)
    for (std::size_t l = 0; l < 8; ++l) {
      const double d_p = particles.diameter[20 * 8 + l], d_q = particles.diameter[(5 + q) * 8 + l];
      const double expected = 3.0 * static_cast<double>(1 + l) * table(d_p, d_q) / 1e-3;
      EXPECT_NEAR(beta[q * 8 + l], expected, 1e-12 * expected);
    }
}

TEST(Consolidation, BringsThePorosityToItsLeastExponentially) {
  // d eps / dt of one granule, from dg/dt by the chain rule, with liquid inside (phi g > l) and without.
  const Consolidation c{0.3, 0.2};
  for (const double liquid : {0.0, 0.4}) {
    const double solid = 2.0, gas = 1.5, phi = 10.0;
    const double v = solid + liquid + gas, porosity = (liquid + gas) / v;
    const double porosity_rate = solid / (v * v) * -consolidation_rate(c, phi, solid, liquid, gas);
    EXPECT_NEAR(porosity_rate, -0.3 * (porosity - 0.2), 1e-13);
  }
}

TEST(Consolidation, StopsAtTheLeastPorosity) {
  const Consolidation c{0.3, 0.2};
  EXPECT_EQ(consolidation_rate(c, 0.0, 1.0, 0.0, 0.25), 0.0);
  EXPECT_EQ(consolidation_rate(c, 0.0, 1.0, 0.0, 0.1), 0.0);
}

TEST(Particles, FilmHoldsTheExternalLiquid) {
  const double v = 1e-12, outside = 2e-13;
  const double h = film_thickness(v, outside);
  const double d = std::cbrt(6 * v / kPi);

  EXPECT_NEAR(kPi / 6 * (d * d * d - std::pow(d - 2 * h, 3)), outside, 1e-12 * outside);
  EXPECT_EQ(external_liquid(3.0, 4.0, 0.5), 1.0);
  EXPECT_EQ(external_liquid(1.0, 4.0, 0.5), 0.0);
}

}  // namespace
}  // namespace granary::pbm
