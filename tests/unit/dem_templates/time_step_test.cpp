#include "dem_templates/render/time_step.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/units.hpp"
#include "dem_templates/geometry/machine.hpp"

namespace granary::dem {
namespace {

using testing::HasSubstr;

DemCase a_bidisperse_case() {
  DemCase c;
  c.population = {{0.0, 0.44, {0.004, 0.001}, {100, 0}}};
  c.tally.class_edges = {0.001, 0.005};
  c.time_step = 1e-5;
  return c;
}

// One sphere against a fixed elastic Hertz spring, integrated with a step far below the contact time.
struct Impact {
  double duration = 0.0, overlap = 0.0;
};
Impact collide(double mass, double stiffness, double speed) {
  const double dt = 1e-9;
  Impact impact;
  double x = 0.0, v = speed;
  while (true) {
    v -= dt * stiffness * x * std::sqrt(std::max(x, 0.0)) / mass;
    x += dt * v;
    if (x <= 0.0) return impact;
    impact.duration += dt;
    impact.overlap = std::max(impact.overlap, x);
  }
}

TEST(TimeStep, ContactTimeAndOverlapAreThoseOfAnIntegratedHertzImpact) {
  const DemCase c = a_bidisperse_case();
  const double r = 0.002, mass = c.density * 4.0 / 3.0 * kPi * r * r * r;
  const double modulus = 1.0 / ((1 - 0.04) * (1 / 8e6 + 1 / 9.99e8));
  const Impact impact = collide(mass, 4.0 / 3.0 * modulus * std::sqrt(r), tip_speed(c.machine));

  const TimeStepFigures f = time_step_figures(c);

  EXPECT_NEAR(f.contact_time, impact.duration, 5e-3 * impact.duration);  // 2.87 for 2.94 (15/16)^(2/5)
  EXPECT_NEAR(f.impact_overlap * r, impact.overlap, 1e-3 * impact.overlap);
}

TEST(TimeStep, RayleighTimeGrowsWithRadiusAndWithTheRootOfDensity) {
  DemCase c = a_bidisperse_case();
  const double base = time_step_figures(c).rayleigh_time;
  EXPECT_NEAR(base, kPi * 0.002 * std::sqrt(1000.0 * 2.4 / 8e6) / (0.1631 * 0.2 + 0.8766), 1e-15);
  c.density *= 4.0;
  c.population[0].diameter[0] *= 2.0;
  EXPECT_NEAR(time_step_figures(c).rayleigh_time, 4.0 * base, 1e-12);
}

TEST(TimeStep, OnlyParticlesThatExistCount) {
  DemCase c = a_bidisperse_case();
  EXPECT_DOUBLE_EQ(time_step_figures(c).smallest_diameter, 0.004);
  c.population[0].count[1] = 1;
  EXPECT_DOUBLE_EQ(time_step_figures(c).smallest_diameter, 0.001);
}

TEST(TimeStep, FedParticlesCountToo) {
  DemCase c = a_bidisperse_case();
  c.feed_rate = 0.004;
  c.feed_diameter = 0.002;
  EXPECT_DOUBLE_EQ(time_step_figures(c).smallest_diameter, 0.002);
}

TEST(TimeStep, TooLongAStepSaysWhatIsAllowed) {
  DemCase c = a_bidisperse_case();
  EXPECT_FALSE(time_step_problem(time_step_figures(c)));
  EXPECT_TRUE(check_time_step(c, "case.json"));

  c.time_step = 3e-5;
  const auto status = check_time_step(c, "case.json");

  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("case.json: /time_step is too long"));
  c.time_step = largest_time_step(time_step_figures(c)) * (1 - 1e-9);
  EXPECT_TRUE(check_time_step(c, "case.json"));
}

TEST(TimeStep, StiffBondsShortenItWithTheRootOfTheirStiffness) {
  DemCase c = a_bidisperse_case();
  const double without = largest_time_step(time_step_figures(c));
  c.agglomerates.emplace();
  c.agglomerates->bonds.normal_stiffness = 1e13;
  const TimeStepFigures stiff = time_step_figures(c);
  c.agglomerates->bonds.normal_stiffness = 4e13;
  const TimeStepFigures stiffer = time_step_figures(c);

  EXPECT_LT(largest_time_step(stiff), without);
  EXPECT_NEAR(largest_time_step(stiffer), 0.5 * largest_time_step(stiff), 1e-9 * without);
  c.time_step = 1.01 * largest_time_step(stiffer);
  ASSERT_TRUE(time_step_problem(time_step_figures(c)));
  EXPECT_NE(time_step_problem(time_step_figures(c))->find("softer bonds"), std::string::npos);
}

TEST(TimeStep, AStandingImpellerLimitsNothingButRayleigh) {
  DemCase c = a_bidisperse_case();
  c.machine.impeller_speed = 0.0;
  const TimeStepFigures f = time_step_figures(c);
  EXPECT_EQ(f.contact_share, 0.0);
  EXPECT_DOUBLE_EQ(largest_time_step(f), 0.2 * f.rayleigh_time);
}

TEST(TimeStep, WarnsWhereAnImpactExceedsTheGuardsOverlap) {
  DemCase c = a_bidisperse_case();
  c.guard.largest_overlap = 0.2;
  const auto warning = overlap_warning(time_step_figures(c), c);
  ASSERT_TRUE(warning);  // 8 MPa at 12 m/s: a third of the radius
  EXPECT_THAT(*warning, HasSubstr("above the guard's bound of 0.20"));
  c.contact.young_modulus = 1e8;
  EXPECT_FALSE(overlap_warning(time_step_figures(c), c));
}

}  // namespace
}  // namespace granary::dem
