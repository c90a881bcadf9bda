// The workflows we ship say what they promise, and hold the figures of their sources.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "common/units.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/campaign/powder.hpp"

namespace granary::campaign {
namespace {

namespace fs = std::filesystem;

const fs::path kWorkflows = fs::path(GRANARY_SOURCE_DIR) / "workflows";

Campaign read(const std::string& name, const std::vector<std::string>& overrides = {}) {
  auto campaign = read_campaign(kWorkflows / name, overrides);
  EXPECT_TRUE(campaign.has_value()) << (campaign ? "" : campaign.error().message);
  return campaign.value_or(Campaign{});
}

double total(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

TEST(Workflows, AllOfThemAreValid) {
  int n = 0;
  for (const auto& entry : fs::directory_iterator(kWorkflows)) {
    if (entry.path().extension() != ".json") continue;
    ++n;
    const auto campaign = read_campaign(entry.path());
    EXPECT_TRUE(campaign.has_value()) << (campaign ? "" : campaign.error().message);
    EXPECT_EQ(campaign.value_or(Campaign{}).name, entry.path().stem());
  }
  EXPECT_GE(n, 5);
}

TEST(Workflows, Cm5IsTheCaseOfThePapers) {
  const Campaign cm5 = read("cm5.json");

  EXPECT_EQ(cm5.kind, Kind::coupled);
  EXPECT_EQ(cm5.pbm_case.grid.bins, (std::array{16, 16}));
  EXPECT_EQ(cm5.pbm_case.compartments.count, 16);
  EXPECT_DOUBLE_EQ(cm5.duration, 150.0);  // the published 100 s are over, and steady, before
  EXPECT_DOUBLE_EQ(*cm5.pbm_case.compartments.residence_time, 49.0);
  EXPECT_NEAR(cm5.dem_case.machine.impeller_speed, 2000.0 * 2.0 * kPi / 60.0, 1e-9);
  EXPECT_DOUBLE_EQ(cm5.dem_case.contact.young_modulus, 8e6);
  EXPECT_DOUBLE_EQ(*cm5.dem.density, 500.0);
  EXPECT_DOUBLE_EQ(cm5.pbm_case.spray->start, 25.0);
  EXPECT_NEAR(cm5.pbm_case.spray->rate, 1.458e-6, 1e-9);  // L/S 0.35 of 15 kg/h at 1000 kg/m^3
  EXPECT_EQ(cm5.pbm_case.spray->compartment, 0);
  EXPECT_EQ(cm5.coupling.mode, CouplingSettings::Mode::two_way);
}

TEST(Workflows, PublishedFeedIs15KilogramsAnHour) {
  const pbm::Grid grid;
  const auto feed = published_feed(grid);

  ASSERT_TRUE(feed.has_value());
  ASSERT_EQ(feed->size(), 9u);
  EXPECT_NEAR(solid_mass(*feed, grid, {}) * 3600.0, 15.0, 1e-3);
}

TEST(Workflows, PublishedFeedKeepsParticlesAndSolidsOnAnotherGrid) {
  const pbm::Grid published, finer{{40, 33}, {4e-16, 3e-16}, {1.7, 2.0}};
  const auto reference = published_feed(published), shared = published_feed(finer);
  ASSERT_TRUE(reference.has_value() && shared.has_value());

  const auto sums = [](const std::vector<pbm::ClassRate>& classes, const pbm::Grid& grid) {
    std::array<double, 3> sum{};
    for (const auto& fed : classes) {
      sum[0] += fed.rate;
      sum[1] += fed.rate * pivot(grid, 0, fed.i);
      sum[2] += fed.rate * pivot(grid, 1, fed.j);
    }
    return sum;
  };
  const auto before = sums(*reference, published), after = sums(*shared, finer);

  EXPECT_GT(shared->size(), 9u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(after[k] / before[k], 1.0, 1e-12);
}

TEST(Workflows, HoldUpIsWhatASteadyFeedLeaves) {
  const Campaign cm5 = read("cm5.json");

  double mass = 0.0, solid = 0.0, gas = 0.0;
  for (const pbm::InitialClass& held : cm5.pbm_case.initial) {
    const double volume = pivot(cm5.pbm_case.grid, 0, held.i) + pivot(cm5.pbm_case.grid, 1, held.j);
    mass += 476.0 * volume * held.number;
    solid += volume * held.number;
    gas += held.gas;
    EXPECT_EQ(held.compartment, -1);
  }

  EXPECT_NEAR(mass, 15.0 / 3600.0 * 49.0 / 16.0, 1e-9);  // 12.8 g in each compartment
  EXPECT_NEAR(gas / solid, 0.5, 1e-12);                  // porosity 1/3
}

TEST(Workflows, CompartmentsShareTheMachineAlongItsAxis) {
  const Campaign quick = read("quick.json");

  ASSERT_EQ(quick.compartment_edges.size(), 5u);
  EXPECT_DOUBLE_EQ(quick.compartment_edges.front(), 0.0);
  EXPECT_DOUBLE_EQ(quick.compartment_edges.back(), 0.44);
  ASSERT_EQ(quick.pbm_case.compartments.volume.size(), 4u);
  EXPECT_NEAR(total(quick.pbm_case.compartments.volume), 4.05e-3, 0.1e-3);  // casing less shaft and blades
}

TEST(Workflows, BedVolumeIsSharedEvenlyWhereGiven) {
  const Campaign quick = read("quick.json", {"/machine/bed_volume=2 l"});

  EXPECT_THAT(quick.pbm_case.compartments.volume, testing::Each(testing::DoubleNear(0.5e-3, 1e-12)));
}

TEST(Workflows, BatchStartsFromItsChargeAndFlowsNowhere) {
  const Campaign bowl = read("batch_bowl.json");

  double mass = 0.0;
  for (const pbm::InitialClass& held : bowl.pbm_case.initial)
    mass += 476.0 * held.number * (pivot(bowl.pbm_case.grid, 0, held.i) + pivot(bowl.pbm_case.grid, 1, held.j));

  EXPECT_NEAR(mass, 0.020, 1e-9);
  EXPECT_FALSE(bowl.pbm_case.feed.has_value());
  EXPECT_FALSE(bowl.pbm_case.compartments.residence_time.has_value());
  EXPECT_EQ(bowl.pbm_case.compartments.count, 1);
  EXPECT_NEAR(bowl.pbm_case.spray->rate * 30.0 * 1000.0, 0.25 * 0.020, 1e-12);  // all liquid by the end of the spray
  EXPECT_EQ(bowl.dem_case.feed_rate, 0.0);
}

TEST(Workflows, WhatIsLeftOutIsNotModelled) {
  const Campaign bare = read("pbm_only.json");
  EXPECT_TRUE(bare.pbm_case.aggregation.has_value());

  const Campaign quick = read("quick.json");
  EXPECT_TRUE(quick.pbm_case.breakage.has_value());
  EXPECT_FALSE(quick.pbm_case.restart.has_value());
  EXPECT_FALSE(quick.pbm_case.dem.has_value());
}

TEST(Workflows, FeedInTheDemCanBeSwitchedOff) {
  EXPECT_NEAR(read("quick.json").dem_case.feed_rate, 15.0 / 3600.0, 1e-12);
  EXPECT_EQ(read("quick.json", {"/dem/through_flow=false"}).dem_case.feed_rate, 0.0);
}

TEST(Workflows, TheBreakageStudyIsTheTwentyCasesOfItsSource) {
  const Campaign study = read("breakage_study.json");

  EXPECT_EQ(study.kind, Kind::sweep);
  ASSERT_EQ(study.sweep.cases.size(), 20u);
  const dem::DemCase &first = study.sweep.cases.front().understood->dem_case,
                     &last = study.sweep.cases.back().understood->dem_case;
  EXPECT_NEAR(first.machine.impeller_speed, 50.0 * 2.0 * kPi / 60.0, 1e-9);
  EXPECT_NEAR(last.machine.chopper_speed, 3000.0 * 2.0 * kPi / 60.0, 1e-9);
  // Figures of the source: chopper tip 3.454 m/s at 3000 rpm, 37 spheres of 1.2 mm, 1500 kg/m^3, and its two ratios.
  EXPECT_NEAR(last.machine.chopper_speed * 0.5 * last.machine.bowl.chopper_diameter, 3.456, 1e-3);
  EXPECT_EQ(last.agglomerates->spheres, 37);
  EXPECT_DOUBLE_EQ(last.agglomerates->sphere_diameter, 1.2e-3);
  EXPECT_DOUBLE_EQ(last.density, 1500.0);
  EXPECT_DOUBLE_EQ(last.agglomerates->bonds.shear_stiffness_ratio, 0.458);
  EXPECT_DOUBLE_EQ(last.agglomerates->bonds.shear_strength_ratio, 0.563);
  EXPECT_DOUBLE_EQ(last.duration, 2.0);
}

TEST(Workflows, TasksKeepTheirOrderAndDependencies) {
  const Campaign list = read("tasks.json");

  EXPECT_EQ(list.kind, Kind::tasks);
  ASSERT_EQ(list.tasks.size(), 5u);
  EXPECT_EQ(list.tasks[3].name, "sum_up");
  EXPECT_EQ(list.tasks[3].after, (std::vector<std::string>{"left", "right"}));
  EXPECT_TRUE(list.tasks[4].fill);
}

TEST(Workflows, AMachineWithTooFewCoresIsRefused) {
  const Campaign cm5 = read("cm5.json", {"/dem/ranks=2", "/pbm/ranks=2", "/pbm/threads=1"});

  EXPECT_TRUE(check_resources(cm5, 1, 2).has_value());
  EXPECT_TRUE(check_resources(cm5, 2, 1).has_value());
  const auto refused = check_resources(cm5, 1, 1);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().exit, Exit::bad_input);
  EXPECT_THAT(refused.error().message,
              testing::HasSubstr("/dem/ranks is 2: a DEM burst needs 2 cores, more than the 1 there are."));
  EXPECT_THAT(refused.error().message, testing::HasSubstr("/pbm/ranks is 2"));
}

}  // namespace
}  // namespace granary::campaign
