// The decks we write, on real LIGGGHTS: both machines, feeding, restarting, the blades' angle and speed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/units.hpp"
#include "dem_templates/geometry/stl.hpp"
#include "dem_templates/render/time_step.hpp"
#include "tests/liggghts/mixer_deck.hpp"

namespace granary::dem::test {
namespace {

struct Speeds {
  double largest = 0.0;
  int particles = 0;  // in the last snapshot
  bool finite = true;
};
constexpr const char* kDumpSpeeds = "dump speeds all custom 100 speeds.txt vx vy vz\n";

Speeds read_speeds(const std::string& text) {
  Speeds speeds;
  std::istringstream lines(text);
  std::string line;
  bool numbers = false;
  while (std::getline(lines, line)) {
    if (line.starts_with("ITEM:")) {
      numbers = line.starts_with("ITEM: ATOMS");
      if (numbers) speeds.particles = 0;
      continue;
    }
    if (!numbers) continue;
    double v[3];
    std::istringstream words(line);
    if (!(words >> v[0] >> v[1] >> v[2]))
      speeds.finite = false;
    else
      speeds.largest = std::max(speeds.largest, std::hypot(v[0], v[1], v[2]));
    ++speeds.particles;
  }
  return speeds;
}

/// Angle of the mixer's first blade around the axis in a dumped STL, and the tip circle's radius.
struct Turned {
  double angle = 0.0, radius = 0.0;
};
Turned first_blade(const Mesh& impeller) {
  Vec3 first{1.0, 0.0, 0.0};
  Turned turned;
  for (Vec3 p : impeller.vertex) turned.radius = std::max(turned.radius, std::hypot(p.y, p.z));
  for (Vec3 p : impeller.vertex)
    if (std::hypot(p.y, p.z) > 0.9 * turned.radius && p.x < first.x) first = p;
  turned.angle = std::atan2(first.z, first.y);
  return turned;
}

double turns_between(double from, double to) { return std::remainder(to - from, 2 * kPi) / (2 * kPi); }

TEST(MixerDeck, RunsAtTipSpeedAndLosesNothing) {
  Folder folder;
  const DemCase c = a_mixer();
  ASSERT_FALSE(time_step_problem(time_step_figures(c)));

  ASSERT_EQ(run_burst(folder, "0001-dem", c, kDumpSpeeds), 0) << folder.read("err");

  const Counted counted(folder, "0001-dem/tallies.jsonl");
  ASSERT_EQ(counted.windows.size(), 4u);
  EXPECT_EQ(counted.total("lost"), 0.0);
  EXPECT_LT(counted.total("left"), 60.0);
  EXPECT_GT(counted.impacts("impeller"), 30.0);
  EXPECT_GT(counted.all_collisions(), 10.0);
  for (const json::Value& window : counted.windows) {
    const json::Value& load = window["loads"]["impeller"];
    EXPECT_GT(load.number_or("power_W", 0), 1.0);
    EXPECT_NEAR(load.number_or("power_W", 0), -load.number_or("axial_torque_N_m", 0) * c.machine.impeller_speed,
                1e-9 * load.number_or("power_W", 0));
  }
  const Speeds speeds = read_speeds(folder.read("0001-dem/speeds.txt"));
  EXPECT_TRUE(speeds.finite);
  const double tip = tip_speed(c.machine);
  EXPECT_GT(speeds.largest, 0.9 * tip);
  EXPECT_LT(speeds.largest, 1.5 * tip);  // (1 + restitution) times; 9.5 times if rpm were taken for rad/s
  EXPECT_TRUE(fs::is_regular_file(folder / "0001-dem" / "restart.liggghts"));
}

/// Where the particles are at the end of a run: dumped at the last step of the burst.
constexpr const char* kDumpPlaces = "dump places all custom 500 places.txt id x y z\ndump_modify places sort id\n";

std::string last_snapshot(const std::string& text) { return text.substr(text.rfind("ITEM: ATOMS")); }

TEST(MixerDeck, ARunCutByARestartGoesOnAsIfItHadNotBeenCut) {
  Folder folder;
  DemCase c = filled(Machine{}, 24, 0.004, 4);  // so few that none is squeezed, and moved by the resize, at the cut
  c.machine.mixer.outlet_open = false;
  c.settle_time = 0.0;
  c.duration = 0.02;
  ASSERT_EQ(run_burst(folder, "whole", c, kDumpPlaces), 0) << folder.read("err");

  c.duration = 0.01;
  ASSERT_EQ(run_burst(folder, "0001-dem", c, kDumpPlaces), 0) << folder.read("err");
  c.restart = "../0001-dem/restart.liggghts";
  ASSERT_EQ(run_burst(folder, "0002-dem", c, kDumpPlaces), 0) << folder.read("err");

  EXPECT_EQ(last_snapshot(folder.read("0002-dem/places.txt")), last_snapshot(folder.read("whole/places.txt")));
  EXPECT_NE(last_snapshot(folder.read("0001-dem/places.txt")), last_snapshot(folder.read("whole/places.txt")));
  EXPECT_GT(Counted(folder, "0002-dem/tallies.jsonl").impacts("impeller"), 3.0);
}

TEST(MixerDeck, ARestartIntoOtherWallsIsRefused) {
  Folder folder;
  DemCase c = a_mixer();
  ASSERT_TRUE(write_burst(c, folder / "0001-dem"));
  folder.write("0001-dem/restart.liggghts", "");
  c.restart = "../0001-dem/restart.liggghts";
  c.walls = Walls::stock;
  const Status refused = write_burst(c, folder / "0002-dem");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("other walls"));
}

TEST(MixerDeck, ARestartOnStockWallsGoesOnWithTheBladesWhereTheyWereAndHasTheNewSizes) {
  Folder folder;
  DemCase c = a_mixer();
  c.walls = Walls::stock;
  c.settle_time = 0.005;
  c.duration = 0.0075;
  c.tally.window = 0.0025;
  ASSERT_EQ(run_burst(folder, "0001-dem", c, "dump blades all mesh/stl 1250 blades*.stl impeller\n"), 0)
      << folder.read("err");

  c.restart = "../0001-dem/restart.liggghts";
  for (Population& p : c.population) p.diameter = {0.0045, 0.005}, p.count = {p.count[0] / 2, p.count[0] / 4};
  c.tally.class_edges = {0.004, 0.00475, 0.006};
  ASSERT_EQ(run_burst(folder, "0002-dem", c, "dump blades all mesh/stl 1250 blades*.stl impeller\n"), 0)
      << folder.read("err");

  const auto mesh = [&](const std::string& file) { return *read_stl(folder / file); };
  const Turned start = first_blade(mesh("0001-dem/blades0.stl"));
  const Turned handed_over = first_blade(mesh("0002-dem/blades1250.stl"));
  const Turned end = first_blade(mesh("0002-dem/blades2500.stl"));
  const double turns = 1250 * c.time_step * c.machine.impeller_speed / (2 * kPi);  // 0.41667
  EXPECT_NEAR(turns_between(start.angle, handed_over.angle), std::remainder(turns, 1.0), 1e-3);
  EXPECT_NEAR(turns_between(start.angle, end.angle), std::remainder(2 * turns, 1.0), 1e-3);
  EXPECT_NEAR(end.radius, 0.057, 1e-5);

  const Counted before(folder, "0001-dem/tallies.jsonl"), after(folder, "0002-dem/tallies.jsonl");
  ASSERT_EQ(after.windows.size(), 3u);
  EXPECT_GT(after.windows.front().number_or("time_s", 0), before.windows.back().number_or("time_s", 0));
  double small = 0.0, large = 0.0, asked_small = 0.0, asked_large = 0.0;
  for (const json::Value& compartment : after.windows.front()["particles"].items()) {
    small += compartment.numbers()[0];
    large += compartment.numbers()[1];
  }
  for (const Population& p : c.population)
    asked_small += static_cast<double>(p.count[0]), asked_large += static_cast<double>(p.count[1]);
  EXPECT_NEAR(small, asked_small, 0.05 * asked_small);  // some may have left while the bed settled
  EXPECT_NEAR(large, asked_large, 0.05 * asked_large);
}

TEST(MixerDeck, FeedsAtTheRateAskedFor) {
  Folder folder;
  DemCase c = a_mixer();
  const double particle = c.density * kPi / 6 * std::pow(0.004, 3);
  c.feed_rate = particle / 0.0005;  // one each 0.5 ms
  c.feed_diameter = 0.004;

  ASSERT_EQ(run_burst(folder, "0001-dem", c), 0) << folder.read("err");

  const Counted counted(folder, "0001-dem/tallies.jsonl");
  EXPECT_NEAR(counted.total("inserted"), c.duration / 0.0005, 12.0);
  EXPECT_EQ(counted.total("lost"), 0.0);
}

TEST(MixerDeck, TheRefinedMeshRunsToo) {
  Folder folder;
  DemCase c = a_mixer();
  c.machine.refinement = 3;
  c.contact.rolling_friction = 0.05;
  c.settle_time = 0.001;
  c.duration = 0.002;
  c.tally.window = 0.001;
  EXPECT_EQ(run_burst(folder, "0001-dem", c), 0) << folder.read("err");
}

TEST(MixerDeck, TheUsersOwnMeshesRunToo) {
  Folder folder;
  folder.write("shell.stl", stl_text(mixer_shell({}), "mine"));
  DemCase c = a_mixer();
  c.machine.shell_stl = folder / "shell.stl";
  c.settle_time = 0.001;
  c.duration = 0.002;
  c.tally.window = 0.001;
  EXPECT_EQ(run_burst(folder, "0001-dem", c), 0) << folder.read("err");
}

TEST(BowlDeck, RunsAndKeepsEveryParticle) {
  Folder folder;
  const DemCase c = a_bowl();

  ASSERT_EQ(run_burst(folder, "0001-dem", c, kDumpSpeeds), 0) << folder.read("err");

  const Counted counted(folder, "0001-dem/tallies.jsonl");
  EXPECT_EQ(counted.total("lost"), 0.0);
  EXPECT_EQ(counted.total("left"), 0.0);
  EXPECT_GT(counted.impacts("impeller"), 0.0);
  const Speeds speeds = read_speeds(folder.read("0001-dem/speeds.txt"));
  EXPECT_TRUE(speeds.finite);
  EXPECT_EQ(speeds.particles, 300);
  EXPECT_GT(speeds.largest, 0.5 * c.machine.impeller_speed * 0.0396);
  EXPECT_LT(speeds.largest, 1.5 * tip_speed(c.machine));  // the chopper's
}

TEST(BowlDeck, ARestartOnTwoRanksGoesOn) {
  Folder folder;
  DemCase c = a_bowl();
  c.settle_time = 0.005;
  c.duration = 0.005;
  ASSERT_EQ(run_burst(folder, "0001-dem", c), 0) << folder.read("err");

  c.restart = "../0001-dem/restart.liggghts";
  c.settle_time = 0.001;
  c.duration = 0.002;
  c.tally.window = 0.001;
  c.ranks = 2;
  ASSERT_EQ(run_burst(folder, "0002-dem", c, kDumpSpeeds, 2), 0) << folder.read("err");

  EXPECT_EQ(read_speeds(folder.read("0002-dem/speeds.txt")).particles, 300);
}

}  // namespace
}  // namespace granary::dem::test
