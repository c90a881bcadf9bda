// The lines of tallies.jsonl: what is summed where, and how it is printed.
#include "dem_templates/plugin/tally/window.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace granary::dem {
namespace {

TallyLayout layout() {
  TallyLayout made;
  made.class_edges = {0.001, 0.002, 0.003};
  made.compartment_edges = {0.0, 0.1, 0.2};
  made.speed_edges = log_spaced(0.1, 10.0, 2);
  made.bodies = {"shell", "impeller"};
  return made;
}

TEST(TallyBins, TakeWhatLiesOutsideIntoTheEndBins) {
  const std::vector<double> edges{1.0, 2.0, 4.0};
  EXPECT_EQ(bin_of(edges, 0.5), 0u);
  EXPECT_EQ(bin_of(edges, 1.0), 0u);
  EXPECT_EQ(bin_of(edges, 2.0), 1u);
  EXPECT_EQ(bin_of(edges, 4.0), 1u);
  EXPECT_EQ(bin_of(edges, 9.0), 1u);
}

TEST(TallyBins, AreEvenInTheLogarithm) {
  const auto edges = log_spaced(0.01, 100.0, 4);
  for (int i = 0; i <= 4; ++i)
    EXPECT_NEAR(edges[static_cast<std::size_t>(i)], std::pow(10.0, i - 2), 1e-12 * std::pow(10.0, i - 2));
}

TEST(Window, CountsEachUnorderedPairOnceAndPrintsASymmetricMatrix) {
  const TallyLayout bins = layout();
  Window window(bins);
  window.collision(0.0015, 0.0025, 0.05, 1.0);
  window.collision(0.0025, 0.0015, 0.15, 1.0);
  window.collision(0.0025, 0.0025, 0.15, 1.0);

  const auto line = window.line({});

  const auto& rows = line["collisions"].items();
  EXPECT_EQ(rows[0].numbers(), (std::vector<double>{0, 2}));
  EXPECT_EQ(rows[1].numbers(), (std::vector<double>{2, 1}));
  EXPECT_EQ(line.numbers("collisions_by_compartment"), (std::vector<double>{1, 2}));
  EXPECT_EQ(line["collision_speed"].number_or("count", 0), 3.0);
}

TEST(Window, SummarisesSpeedsByMeanLogarithmAndHistogram) {
  const TallyLayout bins = layout();
  Window window(bins);
  for (double speed : {0.5, 2.0}) window.impact(1, 0.0015, 0.05, speed);

  const auto line = window.line({});

  const auto& speeds = line["impact_speed"];
  EXPECT_DOUBLE_EQ(speeds.number_or("mean", 0), 1.25);
  EXPECT_NEAR(speeds.number_or("ln_mean", 9), 0.0, 1e-15);
  EXPECT_NEAR(speeds.number_or("ln_variance", 0), std::log(2.0) * std::log(2.0), 1e-15);
  EXPECT_EQ(speeds.numbers("histogram"), (std::vector<double>{1, 1}));
  EXPECT_EQ(line["impacts"].numbers("impeller"), (std::vector<double>{2, 0}));
  EXPECT_EQ(line["impacts"].numbers("shell"), (std::vector<double>{0, 0}));
}

TEST(Window, TakesATouchAtRestForTheSlowestBinSoThatItDoesNotWidenTheDistribution) {
  const TallyLayout bins = layout();
  Window window(bins);
  const double slowest = bins.speed_edges.front();
  for (double speed : {2.0, 0.0}) window.impact(1, 0.0015, 0.05, speed);

  const auto line = window.line({});

  EXPECT_NEAR(line["impact_speed"].number_or("ln_mean", 9), 0.5 * std::log(2.0 * slowest), 1e-15);
}

TEST(Window, AveragesParticlesOverItsSurveys) {
  const TallyLayout bins = layout();
  Window window(bins);
  for (int survey = 0; survey < 4; ++survey) {
    window.particle(0.0015, 0.05, 0.3, 0.25, 1e-6);
    if (survey < 2) window.particle(0.0025, 0.15, -0.1, 1.0, 2e-6);
    window.survey_done();
  }

  const auto line = window.line({});

  EXPECT_EQ(line["particles"].items()[0].numbers(), (std::vector<double>{1, 0}));
  EXPECT_EQ(line["particles"].items()[1].numbers(), (std::vector<double>{0, 0.5}));
  EXPECT_NEAR(line.numbers("solid_volume_m3")[0], std::numbers::pi / 6 * std::pow(0.0015, 3), 1e-22);
  EXPECT_DOUBLE_EQ(line.numbers("speed_mean_m_s")[0], 0.5);
  EXPECT_DOUBLE_EQ(line.numbers("speed_rms_m_s")[1], 1.0);
  EXPECT_NEAR(line.numbers("axial_velocity_m_s")[1], -0.1, 1e-15);
  EXPECT_NEAR(line.number_or("kinetic_energy_J", 0), 0.5e-6 * 0.25 + 0.5 * 0.5 * 2e-6, 1e-18);
}

TEST(Window, CountsTheEdgesAParticleCrossed) {
  const TallyLayout bins = layout();
  Window window(bins);
  window.moved(0.05, 0.25);  // over 0.1 and 0.2
  window.moved(0.15, 0.12);  // over none
  window.moved(0.12, 0.08);  // back over 0.1
  window.moved(0.08, 0.11);

  EXPECT_EQ(window.line({}).numbers("axial_flux"), (std::vector<double>{0, 1, 1}));
}

TEST(Window, StartsAnewAfterItsLine) {
  const TallyLayout bins = layout();
  Window window(bins);
  window.collision(0.0015, 0.0015, 0.05, 1.0);
  window.overlap(0.1);
  window.clear();

  const auto line = window.line({});
  EXPECT_EQ(line["collisions"].items()[0].numbers()[0], 0.0);
  EXPECT_EQ(line.number_or("largest_overlap", 1), 0.0);
}

}  // namespace
}  // namespace granary::dem
