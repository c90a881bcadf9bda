#include "dem_templates/render/automatic.hpp"

#include <gtest/gtest.h>

#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/render/time_step.hpp"

namespace granary::dem {
namespace {

DemCase an_automatic_case() {
  DemCase c;
  c.population = {{0.0, 0.44, {0.004}, {100}}};
  c.contact.young_modulus = 1e8;
  return c;
}

TEST(AutomaticTimeStep, IsTheLongestAllowedWithTwoDigits) {
  for (const double modulus : {5e6, 8e6, 1e8, 3e9}) {
    DemCase c = an_automatic_case();
    c.contact.young_modulus = modulus;
    const double longest = largest_time_step(time_step_figures(c));
    EXPECT_LE(automatic_time_step(c), longest);
    EXPECT_GT(automatic_time_step(c), 0.9 * longest);
    c.time_step = automatic_time_step(c);
    EXPECT_FALSE(time_step_problem(time_step_figures(c)));
  }
}

TEST(AutomaticTimeStep, GoesByTheMeasuredSpeedWhereThereIsOne) {
  DemCase c = an_automatic_case();
  const double at_tip_speed = automatic_time_step(c);
  c.impact_speed = 2.0 * tip_speed(c.machine);
  EXPECT_LT(automatic_time_step(c), at_tip_speed);
  c.impact_speed = 0.5 * tip_speed(c.machine);
  EXPECT_GT(automatic_time_step(c), at_tip_speed);
}

TEST(AutomaticTallyEvery, SeesEachContactAtLeastOnce) {
  DemCase c = an_automatic_case();
  for (const double part : {1.0, 0.5, 0.2}) {
    c.time_step = part * largest_time_step(time_step_figures(c));
    const TimeStepFigures f = time_step_figures(c);
    EXPECT_LT(automatic_tally_every(c) * c.time_step, f.contact_time);
    EXPECT_GE(automatic_tally_every(c), 9);
  }
}

TEST(AutomaticStiffness, GivesTheOverlapAskedForWhateverTheSize) {
  for (const double diameter : {0.001, 0.004, 0.01}) {
    DemCase c = an_automatic_case();
    c.population[0].diameter = {diameter};
    c.contact.young_modulus = automatic_young_modulus(c, 0.2);
    EXPECT_LT(c.contact.young_modulus, 1e8);
    EXPECT_NEAR(time_step_figures(c).impact_overlap, 0.2, 1e-9);
  }
}

TEST(AutomaticStiffness, NeverMakesParticlesStifferNorTooSoftForLiggghts) {
  EXPECT_EQ(automatic_young_modulus(an_automatic_case(), 0.01), 1e8);
  EXPECT_EQ(automatic_young_modulus(an_automatic_case(), 0.9), 5e6);
}

TEST(AutomaticRankGrid, CutsTheMixerIntoSlicesTheBowlIntoColumns) {
  DemCase mixer = an_automatic_case();
  mixer.ranks = 8;
  EXPECT_EQ(automatic_rank_grid(mixer), (std::array<int, 3>{8, 1, 1}));
  mixer.ranks = 64;  // slices of 27 particles' length at most
  const auto grid = automatic_rank_grid(mixer);
  EXPECT_EQ(grid[0] * grid[1] * grid[2], 64);
  EXPECT_EQ(grid[0], 16);

  DemCase bowl = an_automatic_case();
  bowl.machine.type = Machine::Type::batch_bowl;
  bowl.ranks = 6;
  EXPECT_EQ(automatic_rank_grid(bowl), (std::array<int, 3>{3, 2, 1}));
  bowl.ranks = 7;
  EXPECT_EQ(automatic_rank_grid(bowl), (std::array<int, 3>{7, 1, 1}));
}

}  // namespace
}  // namespace granary::dem
