// Mixers and bowls that are hard to simulate: they end right, or with a message that says what to do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/liggghts/mixer_deck.hpp"

namespace granary::dem::test {
namespace {

using testing::HasSubstr;

/// A few revolutions' worth is enough to see a run diverge.
DemCase brief(DemCase c) {
  c.settle_time = 0.003;
  c.duration = 0.006;
  c.tally.window = 0.002;
  c.time_step = automatic_time_step(c);
  return c;
}

double present(const Counted& counted) {
  double sum = 0.0;
  for (const json::Value& compartment : counted.windows.back()["particles"].items())
    for (double n : compartment.numbers()) sum += n;
  return sum;
}

TEST(HardMixer, RunsWithSizesOneToTen) {
  const Folder folder;
  DemCase c = a_mixer();
  for (Population& p : c.population) p.diameter = {0.0008, 0.008}, p.count = {300, 20};
  c.tally.class_edges = {0.0005, 0.002, 0.01};
  c = brief(c);
  ASSERT_EQ(run_burst(folder, "b", c), 0) << folder.read("err");

  const Counted counted(folder, "b/tallies.jsonl");
  EXPECT_EQ(counted.total("lost"), 0.0);
  const auto collisions = counted.collisions();
  EXPECT_GT(collisions[0][1], 50.0) << "small ones with large ones";
  EXPECT_GT(counted.impacts("impeller"), 10.0);
}

TEST(HardMixer, AFirstStepWithParticlesGrownIntoEachOtherIsRelaxedFirst) {
  const Folder folder;
  DemCase c = brief(a_mixer());
  ASSERT_EQ(run_burst(folder, "0001-dem", c), 0) << folder.read("err");
  c.restart = "../0001-dem/restart.liggghts";
  for (Population& p : c.population) p.diameter = {0.008};
  c.tally.class_edges = {0.004, 0.012};
  ASSERT_EQ(run_burst(folder, "0002-dem", brief(c)), 0) << folder.read("err");

  const auto resized = json::read_file(folder / "0002-dem/resize.json");
  ASSERT_TRUE(resized);
  EXPECT_GT(resized->number_or("overlap_resized", 0), 0.5);
  EXPECT_LT(resized->number_or("overlap_left", 1), 0.1);
  EXPECT_EQ(Counted(folder, "0002-dem/tallies.jsonl").total("lost"), 0.0);
}

TEST(HardMixer, RunsWithASingleParticleAndWithARankThatHasNone) {
  const Folder folder;
  DemCase c = a_mixer();
  c.machine.mixer.outlet_open = false;
  for (Population& p : c.population) p.count = {0};
  c.population[1].count = {1};
  c = brief(c);
  ASSERT_EQ(run_burst(folder, "one", c), 0) << folder.read("err");
  EXPECT_NEAR(present(Counted(folder, "one/tallies.jsonl")), 1.0, 1e-9);

  c.population[1].count = {0};
  c.population[0].count = {60};
  c.ranks = 2;
  ASSERT_EQ(run_burst(folder, "two_ranks", brief(c), "", 2), 0) << folder.read("err");
  const Counted counted(folder, "two_ranks/tallies.jsonl");
  EXPECT_NEAR(present(counted), 60.0, 1e-9);
  EXPECT_GT(counted.impacts("impeller"), 5.0);
}

// A bowl of 0.25 l: two thirds of it can be spheres, some 180 of 12 mm.
TEST(HardBowl, SaysThatItIsOverFull) {
  const Folder folder;
  DemCase c = a_bowl();
  c.population[0].diameter = {0.012};
  c.population[0].count = {350};
  c.tally.class_edges = {0.004, 0.015};
  EXPECT_EQ(run_burst(folder, "b", brief(c)), 2);
  EXPECT_THAT(folder.read("err"), HasSubstr("do not fit between"));
}

// 7 mm particles in a mixer whose blades pass the casing at 3 mm: some are caught there.
TEST(HardMixer, AParticlePinchedBetweenBladeAndCasingEndsNoRun) {
  const Folder folder;
  DemCase c = filled(Machine{}, 700, 0.007, 4);
  c.machine.mixer.outlet_open = false;
  c.machine.mixer.outlet_diameter = c.machine.mixer.inlet_diameter;
  c = brief(c);
  c.duration = 0.06;
  ASSERT_EQ(run_burst(folder, "b", c), 0) << folder.read("err");

  const Counted counted(folder, "b/tallies.jsonl");
  EXPECT_EQ(counted.total("lost"), 0.0);
  double deepest = 0.0;
  for (const json::Value& window : counted.windows) deepest = std::max(deepest, window.number_or("largest_overlap", 0));
  EXPECT_GT(deepest, 0.35) << "deeper than a free impact presses: one was pinched";
}

TEST(HardMixer, RunsAtThreeTimesTheSpeed) {
  const Folder folder;
  DemCase c = a_mixer();
  c.machine.impeller_speed *= 3.0;
  c.contact.young_modulus = 8e7;  // 8 MPa would let a blade of 36 m/s through half a particle
  ASSERT_EQ(run_burst(folder, "b", brief(c)), 0) << folder.read("err");
  EXPECT_EQ(Counted(folder, "b/tallies.jsonl").total("lost"), 0.0);
}

}  // namespace
}  // namespace granary::dem::test
