// The tally against collisions worked out by hand, with real LIGGGHTS.
#include <array>
#include <cmath>
#include <random>
#include <set>

#include "tests/liggghts/plugin_deck.hpp"

namespace granary::dem::test {
namespace {

constexpr double kGravity = 9.81;

// ---- one or two particles ----

std::string head_on() {
  return head("-0.05 0.05 -0.02 0.02 -0.02 0.02") + physics() +
         particles({{-0.01, 0, 0, 1.0, 0, 0, 0.004}, {0.01, 0, 0, -0.5, 0, 0, 0.004}});
}

TEST(Tally, CountsTwoParticlesThatMeetOnceWithTheirClosingSpeed) {
  const Folder folder;
  ASSERT_EQ(run_deck(folder, head_on() + tally(kOneBin) + "run 5000\n"), 0) << folder.read("err");

  const Counted counted(folder);
  EXPECT_EQ(counted.all_collisions(), 1.0);
  ASSERT_EQ(counted.speeds("collision_speed").size(), 1u);
  EXPECT_NEAR(counted.speeds("collision_speed")[0], 1.5, 1e-6);
}

TEST(Tally, TakesAContactThatLivesAcrossARestartAsOne) {
  const Folder folder;
  ASSERT_EQ(run_deck(folder, head_on() + tally(kOneBin) + "run 2170\nwrite_restart middle\n"), 0) << folder.read("err");
  EXPECT_EQ(Counted(folder).all_collisions(), 1.0);  // 2133 steps to the touch, about 70 in contact

  ASSERT_EQ(run_deck(folder, head("middle") + physics() + tally(kOneBin) + "run 2830\n"), 0) << folder.read("err");
  const Counted after(folder);
  EXPECT_EQ(after.all_collisions(), 0.0);
  EXPECT_GT(after.windows[0].number_or("largest_overlap", 0), 0.01);  // they did touch
}

// The ranks meet at x = 0; the pair touches from about x = -1.5 mm to 1.7 mm.
TEST(Tally, CountsAPairOnceThatCrossesFromOneRankToTheOther) {
  const Folder folder;
  const std::string deck =
      head("-0.05 0.05 -0.02 0.02 -0.02 0.02") + physics() +
      particles({{-0.0215, -0.004, 0, 10.0, 1.0, 0, 0.004}, {-0.0215, 0.004, 0, 10.0, -1.0, 0, 0.004}}) +
      tally(kOneBin) + "run 800\n";
  ASSERT_EQ(run_deck(folder, deck, 2), 0) << folder.read("err");
  EXPECT_EQ(Counted(folder).all_collisions(), 1.0);
}

/// The same body as LIGGGHTS' wall and as ours.
struct Body {
  std::string walls, keywords;
};

TEST(Tally, CountsThreeBouncesWithTheSpeedsOfFreeFall) {
  const Body stock{"fix floor all wall/gran model hertz tangential history primitive type 1 zplane 0.0\n",
                   "body floor wall floor"};
  const Body ours{"fix walls all granary/wall type 1 plane floor 0 0 0 0 0 1\n", "body floor of walls"};
  for (const Body& body : {stock, ours}) {
    const Folder folder;
    const double height = 0.02, speed = std::sqrt(2 * kGravity * height);
    const std::string deck =
        head("-0.02 0.02 -0.02 0.02 -0.01 0.05") + physics(0.9) + particles({{0, 0, height + 0.002, 0, 0, 0, 0.004}}) +
        "fix g all gravity 9.81 vector 0 0 -1\n" + body.walls + tally(kOneBin + body.keywords, 5, 2000) + "run 66000\n";
    ASSERT_EQ(run_deck(folder, deck), 0) << folder.read("err");

    const Counted counted(folder);
    EXPECT_EQ(counted.impacts("floor"), 3.0);
    const auto speeds = counted.speeds("impact_speed");
    ASSERT_EQ(speeds.size(), 3u);
    EXPECT_NEAR(speeds[0], speed, 1e-3 * speed);
    EXPECT_NEAR(speeds[1], 0.9 * speed, 0.02 * speed);
    EXPECT_NEAR(speeds[2], 0.81 * speed, 0.03 * speed);
  }
}

std::string triangle(const std::array<std::array<double, 3>, 3>& corners) {
  std::ostringstream text;
  text << "facet normal 0 0 0\n outer loop\n";
  for (const auto& c : corners) text << "  vertex " << c[0] << " " << c[1] << " " << c[2] << "\n";
  return text.str() + " endloop\nendfacet\n";
}

std::string solid(const std::string& facets) { return "solid part\n" + facets + "endsolid part\n"; }

TEST(Tally, TakesTheSharedEdgeOfTwoTrianglesAsOneImpact) {
  const Folder folder;
  folder.write("plate.stl", solid(triangle({{{-0.015, -0.015, 0}, {0.015, -0.015, 0}, {0.015, 0.015, 0}}}) +
                                  triangle({{{-0.015, -0.015, 0}, {0.015, 0.015, 0}, {-0.015, 0.015, 0}}})));
  const double height = 0.01;
  const std::string deck =
      head("-0.02 0.02 -0.02 0.02 -0.01 0.05") + physics(0.9) + particles({{0, 0, height + 0.002, 0, 0, 0, 0.004}}) +
      "fix g all gravity 9.81 vector 0 0 -1\n" + "fix plate all mesh/surface file plate.stl type 1\n" +
      "fix walls all wall/gran model hertz tangential history mesh n_meshes 1 meshes plate\n" +
      tally(kOneBin + "body plate mesh plate") + "run 14000\n";
  ASSERT_EQ(run_deck(folder, deck), 0) << folder.read("err");

  const Counted counted(folder);
  EXPECT_EQ(counted.impacts("plate"), 1.0);
  ASSERT_EQ(counted.speeds("impact_speed").size(), 1u);
  EXPECT_NEAR(counted.speeds("impact_speed")[0], std::sqrt(2 * kGravity * height), 1e-3);
}

TEST(Tally, TakesTheSpeedOfAMovingWallIntoAccount) {
  const Folder folder;
  folder.write("paddle.stl", solid(triangle({{{0.01, 0, -0.01}, {0.05, 0, -0.01}, {0.05, 0, 0.01}}}) +
                                   triangle({{{0.01, 0, -0.01}, {0.05, 0, 0.01}, {0.01, 0, 0.01}}})));
  const double omega = 10.0, radius = 0.002;
  const Body stock{
      "fix paddle all mesh/surface file paddle.stl type 1\n"
      "fix walls all wall/gran model hertz tangential history mesh n_meshes 1 meshes paddle\n"
      "fix turn all move/mesh mesh paddle rotate origin 0 0 0 axis 0 0 1 period " +
          std::to_string(2 * M_PI / omega) + "\n",
      "body paddle mesh paddle"};
  const Body ours{"fix walls all granary/wall type 1 mesh paddle paddle.stl rotate paddle 0 0 0 0 0 1 rad/s " +
                      std::to_string(omega) + "\n",
                  "body paddle of walls"};
  for (const Body& body : {stock, ours}) {
    const std::string deck = head("-0.08 0.08 -0.08 0.08 -0.02 0.02") + physics(0.9) +
                             particles({{0.03, 0.01, 0, 0, 0, 0, 2 * radius}}) + body.walls +
                             tally(kOneBin + body.keywords) + "run 8000\n";
    const double expected = omega * std::sqrt(0.03 * 0.03 + 0.01 * 0.01 - radius * radius);

    for (int ranks : {1, 2}) {
      ASSERT_EQ(run_deck(folder, deck, ranks), 0) << folder.read("err");
      const Counted counted(folder);
      EXPECT_EQ(counted.impacts("paddle"), 1.0) << ranks << " ranks";
      ASSERT_EQ(counted.speeds("impact_speed").size(), 1u);
      EXPECT_NEAR(counted.speeds("impact_speed")[0], expected, 0.005 * expected);
    }
  }
}

// A sphere that meets the edge of a plate aside of its centre: the normal turns as it goes in, by the step it is seen
// at.
TEST(Tally, TakesTheNormalSpeedOfFirstTouchAtAnEdge) {
  const double radius = 0.002, aside = 0.0012, speed = 10.0;
  for (const double start : {-0.01, -0.010012, -0.010024, -0.010036}) {  // parts of a step
    const Folder folder;
    folder.write("plate.stl", solid(triangle({{{0, -0.02, 0}, {0.02, -0.02, 0}, {0.02, 0.02, 0}}}) +
                                    triangle({{{0, -0.02, 0}, {0.02, 0.02, 0}, {0, 0.02, 0}}})));
    const std::string deck = head("-0.03 0.03 -0.03 0.03 -0.02 0.02") + physics(0.9) +
                             particles({{start, 0, aside, speed, 0, 0, 2 * radius}}) +
                             "fix walls all granary/wall type 1 mesh plate plate.stl\n" +
                             tally(kOneBin + "body plate of walls") + "run 400\n";
    ASSERT_EQ(run_deck(folder, deck), 0) << folder.read("err");
    const Counted counted(folder);
    EXPECT_EQ(counted.impacts("plate"), 1.0);
    ASSERT_EQ(counted.speeds("impact_speed").size(), 1u);
    const double expected = speed * std::sqrt(1.0 - aside * aside / radius / radius);
    EXPECT_NEAR(counted.speeds("impact_speed")[0], expected, 1e-3 * expected) << start;
  }
}

// A copy of the walls that only watches sees what they see, and changes nothing.
TEST(Tally, HearsTheSameOfWallsThatOnlyWatch) {
  std::vector<TestParticle> list;
  for (int n = 0; n < 30; ++n)
    list.push_back(
        {0.005 * (n % 6) - 0.0125, 0.005 * (n / 6) - 0.01, -0.004 + 1e-4 * n, 0.3, -0.1 * (n % 3), 0, 0.004});
  const std::string drum =
      "cylinder drum 0 0 0 1 0 0 0.018 rotate drum 0 0 0 1 0 0 rad/s 40 plane end 0.018 0 0 1 0 0 "
      "plane start -0.018 0 0 1 0 0\n";
  const auto counted = [&](const std::string& watching, const std::string& fix) {
    const Folder folder;
    EXPECT_EQ(run_deck(folder, head("-0.03 0.03 -0.03 0.03 -0.03 0.03") + physics(0.5, 0.4) + particles(list) +
                                   "fix g all gravity 9.81 vector 0 0 -1\nfix walls all granary/wall type 1 " + drum +
                                   watching + tally(kOneBin + "body drum of " + fix, 5, 5000) + "run 20000\n"),
              0)
        << folder.read("err");
    return Counted(folder);
  };
  const std::string watching = "fix watch all granary/wall type 1 push no " + drum;
  const Counted alone = counted("", "walls"), beside = counted(watching, "walls"), watched = counted(watching, "watch");
  EXPECT_GT(alone.impacts("drum"), 30.0);
  ASSERT_EQ(alone.windows.size(), watched.windows.size());
  for (std::size_t w = 0; w < alone.windows.size(); ++w) {
    for (const char* same : {"impacts", "impact_speed", "loads", "kinetic_energy_J", "largest_overlap"}) {
      EXPECT_EQ(json::dump(beside.windows[w][same]), json::dump(alone.windows[w][same])) << same;
      EXPECT_EQ(json::dump(watched.windows[w][same]), json::dump(alone.windows[w][same])) << same;
    }
  }
}

// A drum that turns carries its bed up: what its wall bears must be the bed's weight and what turns it.
TEST(Tally, TellsWhatABodyBears) {
  const Folder folder;
  const double radius = 0.02, mass = 1000.0 * M_PI / 6.0 * std::pow(0.004, 3);
  std::vector<TestParticle> list;
  for (int n = 0; n < 7; ++n) list.push_back({0.005 * n - 0.015, 0, -radius + 0.002, 0, 0, 0, 0.004});
  const std::string deck =
      head("-0.03 0.03 -0.03 0.03 -0.03 0.03") + physics(0.3, 0.5) + particles(list) +
      "fix g all gravity 9.81 vector 0 0 -1\n" +
      "fix walls all granary/wall type 1 cylinder drum 0 0 0 1 0 0 0.02 rotate drum 0 0 0 1 0 0 rad/s 5\n" +
      tally(kOneBin + "body drum of walls", 5, 10000) + "run 20000\n";
  ASSERT_EQ(run_deck(folder, deck), 0) << folder.read("err");

  const Counted counted(folder);
  const json::Value& load = counted.windows.back()["loads"]["drum"];
  EXPECT_NEAR(load.numbers("force_N")[2], -7 * mass * kGravity, 0.03 * 7 * mass * kGravity);
  EXPECT_NEAR(load.number_or("power_W", 0), -5.0 * load.number_or("axial_torque_N_m", 0), 1e-12);
  EXPECT_GE(load.number_or("power_W", 0), 0.0);
}

TEST(Tally, CountsWhoCrossesEdgesAndWhoLeaves) {
  const Folder folder;
  const std::string deck =
      head("-0.05 0.05 -0.02 0.02 -0.02 0.02") + physics() +
      particles({{-0.03, 0, -0.01, 2, 0, 0, 0.004}, {-0.02, 0, 0, 2, 0, 0, 0.004}, {0.01, 0, 0.01, -1, 0, 0, 0.004}}) +
      "region end block 0.03 0.05 INF INF INF INF units box\nfix out all granary/outlet region end\n" +
      tally("axis x compartments 2 -0.05 0 0.03 classes 1 0.001 0.01") + "run 7000\n";
  for (int ranks : {1, 2}) {
    ASSERT_EQ(run_deck(folder, deck, ranks), 0) << folder.read("err");
    const Counted counted(folder);
    std::vector<double> flux(3, 0.0);
    for (const auto& window : counted.windows)
      for (std::size_t e = 0; e < 3; ++e) flux[e] += window.numbers("axial_flux")[e];
    EXPECT_EQ(flux, (std::vector<double>{0, 2 - 1, 2})) << ranks << " ranks";
    EXPECT_EQ(counted.total("left"), 2.0);
    EXPECT_EQ(counted.total("lost"), 0.0);
  }
}

// ---- a gas of two sizes in a periodic box ----

constexpr double kSide = 0.04;

std::string gas() {
  std::mt19937 random(4711);
  std::uniform_real_distribution<double> place(0.0, kSide), speed(-1.5, 1.5);
  std::vector<TestParticle> list;
  while (list.size() < 150) {
    const TestParticle p{place(random),
                         place(random),
                         place(random),
                         speed(random),
                         speed(random),
                         speed(random),
                         list.size() % 2 ? 0.003 : 0.004};
    const auto overlaps = [&](const TestParticle& q) {
      double d2 = 0.0;
      for (double d : {p.x - q.x, p.y - q.y, p.z - q.z}) d2 += std::pow(d - kSide * std::round(d / kSide), 2);
      return d2 < std::pow(0.52 * (p.diameter + q.diameter), 2);
    };
    if (std::none_of(list.begin(), list.end(), overlaps)) list.push_back(p);
  }
  return particles(list);
}

const std::string kGasBins = "axis x compartments 2 0 0.02 0.04 classes 2 0.002 0.0035 0.005";

std::string gas_deck(int every, const std::string& after) {
  return head("0 0.04 0 0.04 0 0.04", "p p p") + physics(0.95, 0.2) + gas() + tally(kGasBins, every, 500) + after;
}

// Contacts that began, counted from positions and radii of every step.
std::vector<std::vector<double>> count_by_hand(const fs::path& dump) {
  std::ifstream in(dump);
  std::vector<std::vector<double>> began(2, std::vector<double>(2, 0.0));
  std::set<std::pair<int, int>> before;
  bool first = true;
  for (std::string line; std::getline(in, line);) {
    if (line != "ITEM: NUMBER OF ATOMS") continue;
    std::getline(in, line);
    const int n = std::stoi(line);
    while (std::getline(in, line) && line.rfind("ITEM: ATOMS", 0) != 0) {
    }
    struct Row {
      int id;
      double x[3], r;
    };
    std::vector<Row> rows(static_cast<std::size_t>(n));
    for (Row& row : rows) in >> row.id >> row.x[0] >> row.x[1] >> row.x[2] >> row.r;
    std::set<std::pair<int, int>> now;
    for (std::size_t a = 0; a < rows.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        double d2 = 0.0;
        for (int k = 0; k < 3; ++k) {
          const double d = rows[a].x[k] - rows[b].x[k];
          d2 += std::pow(d - kSide * std::round(d / kSide), 2);
        }
        if (d2 >= std::pow(rows[a].r + rows[b].r, 2)) continue;
        const auto pair = std::minmax(rows[a].id, rows[b].id);
        now.insert(pair);
        if (first || before.contains(pair)) continue;
        const std::size_t p = rows[a].r > 0.00175, q = rows[b].r > 0.00175;
        began[p][q] += 1;
        if (p != q) began[q][p] += 1;
      }
    }
    before = now;
    first = false;
  }
  return began;
}

TEST(Tally, AgreesWithACountByHandFromThePositionsOfEveryStep) {
  const Folder folder;
  const std::string dump =
      "dump d all custom 1 dump.txt id x y z radius\ndump_modify d format \"%d %.17g %.17g %.17g %.17g\"\n";
  // The second law is worked out by LIGGGHTS.
  for (const std::string law : {"tangential history", "tangential history rolling_friction epsd2"})
    for (const int every : {1, 5, 100, 500}) {
      std::string deck = gas_deck(every, dump + "run 2000\n");
      deck.replace(deck.find("tangential history"), std::string("tangential history").size(), law);
      if (law != "tangential history")
        deck.insert(deck.find("pair_style"),
                    "fix mr all property/global coefficientRollingFriction peratomtypepair 1 0.1\n");
      ASSERT_EQ(run_deck(folder, deck), 0) << folder.read("err");

      const auto counted = Counted(folder).collisions();
      const auto by_hand = count_by_hand(folder / "dump.txt");

      EXPECT_EQ(counted, by_hand) << law << ", every " << every;
      EXPECT_GT(by_hand[0][0] + by_hand[0][1] + by_hand[1][1], 50.0);
      EXPECT_EQ(counted[0][1], counted[1][0]);
    }
}

TEST(Tally, OneBesideAnotherCountsAll) {
  const Folder folder;
  const std::string second = "fix other all granary/tally file other.jsonl every 20 window 1000 " + kGasBins + "\n";
  ASSERT_EQ(run_deck(folder, gas_deck(5, second + "run 2000\n")), 0) << folder.read("err");
  const Counted one(folder);
  fs::rename(folder / "other.jsonl", folder / "tallies.jsonl");
  const Counted other(folder);
  EXPECT_GT(one.all_collisions(), 50.0);
  EXPECT_EQ(other.collisions(), one.collisions());
  EXPECT_EQ(other.windows.back().number_or("largest_overlap", 0),
            std::max(one.windows[2].number_or("largest_overlap", 0), one.windows[3].number_or("largest_overlap", 0)));
}

TEST(Tally, GivesTheSameOnOneAndOnTwoRanks) {
  const Folder folder;
  ASSERT_EQ(run_deck(folder, gas_deck(5, "run 3000\n")), 0) << folder.read("err");
  const Counted one(folder);
  ASSERT_EQ(run_deck(folder, gas_deck(5, "run 3000\n"), 2), 0) << folder.read("err");
  const Counted two(folder);

  EXPECT_EQ(one.collisions(), two.collisions());
  EXPECT_EQ(one.total("axial_flux"), two.total("axial_flux"));
  EXPECT_GT(one.all_collisions(), 80.0);
  ASSERT_EQ(one.windows.size(), two.windows.size());
  for (std::size_t w = 0; w < one.windows.size(); ++w)
    EXPECT_NEAR(one.windows[w].number_or("kinetic_energy_J", 0), two.windows[w].number_or("kinetic_energy_J", 1), 1e-9);
}

TEST(Tally, CountsTheSameHoweverSeldomItLooks) {
  const Folder folder;
  ASSERT_EQ(run_deck(folder, gas_deck(1, "run 3000\n")), 0) << folder.read("err");
  const Counted every_step(folder);
  ASSERT_EQ(run_deck(folder, gas_deck(250, "run 3000\n")), 0) << folder.read("err");
  const Counted seldom(folder);

  EXPECT_EQ(seldom.collisions(), every_step.collisions());
  EXPECT_EQ(seldom.speeds("collision_speed"), every_step.speeds("collision_speed"));
  ASSERT_EQ(seldom.windows.size(), every_step.windows.size());
  for (std::size_t w = 0; w < seldom.windows.size(); ++w)
    EXPECT_EQ(seldom.windows[w].number_or("largest_overlap", 0), every_step.windows[w].number_or("largest_overlap", 1));
}

// In free fall onto one that is held: each touch is a contact, also where a look has seen none of it.
TEST(Tally, CountsEachBounceAlsoBetweenTwoLooks) {
  const Folder folder;
  const std::string deck = head("-0.02 0.02 -0.02 0.02 -0.01 0.05") + physics(0.9) +
                           particles({{0, 0, 0, 0, 0, 0, 0.004}, {0, 0, 0.0045, 0, 0, 0, 0.004}}) +
                           "group lower id 1\nfix g all gravity 9.81 vector 0 0 -1\nfix hold lower freeze\n" +
                           tally(kOneBin, 18400, 18400) + "run 18400\n";
  ASSERT_EQ(run_deck(folder, deck), 0) << folder.read("err");
  const Counted counted(folder);
  // The first after sqrt(2 h / g) = 10.1 ms, each flight then 0.9 of the one before, from 2 0.9 10.1 ms on: six in 92
  // ms.
  EXPECT_EQ(counted.all_collisions(), 6.0);
  const double mean = std::sqrt(2 * kGravity * 0.0005) * (1 - std::pow(0.9, 6)) / (6 * 0.1);
  EXPECT_NEAR(counted.speeds("collision_speed")[0], mean, 0.02 * mean);
}

TEST(Tally, LosesNothingOverARestartAndItsClockGoesOn) {
  const Folder folder;
  const std::string guard = "fix guard all granary/guard file tallies.jsonl overlap 0.5\n";
  ASSERT_EQ(run_deck(folder, gas_deck(5, guard + "run 3000\n")), 0) << folder.read("err");
  const Counted whole(folder);
  ASSERT_EQ(run_deck(folder, gas_deck(5, guard + "run 1450\nwrite_restart middle\n")), 0) << folder.read("err");
  const Counted before(folder);
  ASSERT_EQ(
      run_deck(folder, head("middle", "p p p") + physics(0.95, 0.2) + guard + tally(kGasBins, 5, 500) + "run 1550\n"),
      0)
      << folder.read("err");
  const Counted after(folder);

  EXPECT_EQ(before.all_collisions() + after.all_collisions(), whole.all_collisions());
  EXPECT_EQ(before.total("axial_flux") + after.total("axial_flux"), whole.total("axial_flux"));
  EXPECT_NEAR(after.windows.back().number_or("time_s", 0), 3000 * 5e-6, 1e-12);
  EXPECT_NEAR(before.windows.back().number_or("window_s", 0), 450 * 5e-6, 1e-12);
}

}  // namespace
}  // namespace granary::dem::test
