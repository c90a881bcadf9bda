// Hard cases of granary/wall: each ends right or with a message that says what to do, with real LIGGGHTS.
#include "tests/liggghts/wall_deck.hpp"

namespace granary::dem::test {
namespace {

// The blade comes at 5 m/s, particles at 10 m/s against it: overlaps of half a radius.
TEST(WallHard, ThrowsBackWhatComesAtThreeTimesTheTipSpeed) {
  const Folder folder;
  folder.write("paddle.stl", stl(paddle()));
  const double rate = 100.0, at = 0.045, tip = rate * at;
  const Law law{.restitution = 0.5, .friction = 0.0, .gravity = 0.0};
  const auto frames =
      frames_of(folder, deck(law) + ours("mesh part paddle.stl rotate part 0 0 0 0 0 1 rad/s 100") +
                            particles({{at, 0.001 + kRadius + 2e-4, 0, 0, -2 * tip, 0, 2 * kRadius}}) + run(300, 300));
  const State& after = frames.back().at(1);
  const double expected = tip + law.restitution * 3 * tip;
  EXPECT_NEAR(after.v[1], expected, 0.05 * expected);
}

// Paddle to drum: 3 mm; the particle: 4 mm.
TEST(WallHard, SqueezesAParticleBetweenBladeAndShellAndGoesOn) {
  const Folder folder;
  folder.write("paddle.stl", stl(paddle()));
  const double rate = 40.0;
  const Law law{.friction = 0.9};
  const auto frames = frames_of(
      folder, deck(law) +
                  ours("cylinder drum 0 0 0 0 0 1 0.053 plane low 0 0 -0.011 0 0 1 plane high 0 0 0.011 0 0 1 "
                       "mesh part paddle.stl rotate part 0 0 0 0 0 1 rad/s 40",
                       law) +
                  particles({{0.0505, 0.0035, 0, 0, 0, 0, 2 * kRadius}, {0.0505, 0.008, 0, 0, 0, 0, 2 * kRadius}}) +
                  run(32000, 100));
  double fastest = 0.0;
  for (const Frame& frame : frames) {
    ASSERT_EQ(frame.size(), 2u);
    for (const auto& [id, p] : frame) {
      EXPECT_LT(std::hypot(p.x[0], p.x[1]), 0.053);
      fastest = std::max(fastest, length(p.v));
    }
  }
  EXPECT_GT(fastest, 1.0);
  EXPECT_LT(fastest, 4 * rate * 0.05);
}

TEST(WallHard, StartsWithParticlesThatOverlapTheWallAndCountsNoImpact) {
  const Folder folder;
  const double overlap = 0.3 * kRadius;
  const Law law{.restitution = 1.0, .gravity = 0.0};
  const auto frames = frames_of(folder, deck(law) + ours("plane floor 0 0 0 0 0 1") +
                                            particles({{0, 0, kRadius - overlap, 0, 0, 0, 2 * kRadius}}) +
                                            print_vector(9) + run(400, 400));
  const double energy = 8.0 / 15.0 * effective_young() * std::sqrt(kRadius) * std::pow(overlap, 2.5);
  const double speed = std::sqrt(2 * energy / kMass);
  EXPECT_NEAR(frames.back().at(1).v[2], speed, 0.01 * speed);
  EXPECT_EQ(read_vector(folder).rbegin()->second[7], 0.0);
}

TEST(WallHard, ReboundsRightlyFromAWallAHundredTimesStiffer) {
  for (const double wall_young : {5e8, 5e10}) {
    const Folder folder;
    const Law law{.restitution = 0.6, .gravity = 0.0, .wall_young = wall_young, .more = "hard_particles yes\n"};
    const auto frames = frames_of(folder, deck(law) + ours("plane floor 0 0 0 0 0 1") +
                                              particles({{0, 0, 0.0021, 0, 0, -1, 2 * kRadius}}) + run(1500, 1500));
    EXPECT_NEAR(frames.back().at(1).v[2], 0.6, 0.02);
  }
}

TEST(WallHard, RefusesATimeStepThatAContactIsTooShortForAndNamesAGoodOne) {
  const Folder folder;
  const auto with_step = [&](double time_step) {
    const Law law{.gravity = 0.0, .time_step = time_step};
    return run_deck(folder, deck(law) + ours("plane floor 0 0 0 0 0 1") +
                                particles({{0, 0, 0.0021, 0, 0, -1, 2 * kRadius}}) + "run 100\n");
  };
  EXPECT_EQ(with_step(6e-5), 2);
  const std::string said = folder.read("err"), before = "Take a time step below ";
  const auto place = said.find(before);
  ASSERT_NE(place, std::string::npos) << said;
  EXPECT_NE(said.find("body 'floor': the shortest contact lasts"), std::string::npos) << said;
  EXPECT_EQ(with_step(0.99 * std::stod(said.substr(place + before.size()))), 0) << folder.read("err");
}

TEST(WallHard, RefusesATimeStepInWhichABladeCouldPassAParticle) {
  const Folder folder;
  folder.write("paddle.stl", stl(paddle()));
  // Tip at 50 mm, 5 us, smallest radius 1.5 mm: 3000 rad/s take it half a radius a step.
  const auto with_rate = [&](const std::string& rate) {
    return run_deck(folder, deck({}) + before_the_paddle() +
                                ours("mesh part paddle.stl rotate part 0 0 0 0 0 1 rad/s " + rate) + "run 0\n");
  };
  EXPECT_EQ(with_rate("2990"), 0) << folder.read("err");
  EXPECT_EQ(with_rate("-3010"), 2);
  EXPECT_NE(folder.read("err").find("body 'part'"), std::string::npos) << folder.read("err");
}

// 900 m/s, 4.5 mm a step: more than the particle is wide. It is never on the far side in silence: unseen, or seen too
// late to be stopped.
TEST(WallHard, EndsARunInWhichAParticleGoesThroughABladeWithinAStep) {
  int passed = 0;
  for (const double start : {0.0061, 0.0071, 0.0081, 0.0091}) {
    const Folder folder;
    folder.write("leaf.stl", stl(sheet({-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}, 3)));
    const int code = run_deck(folder, deck({.gravity = 0.0}) + ours("mesh leaf leaf.stl") +
                                          particles({{0.001, 0.002, start, 0, 0, -900, 2 * kRadius}}) + run(4, 1));
    if (code == 0) {
      for (const Frame& frame : read_dump(folder)) EXPECT_GT(frame.at(1).x[2], 0.0) << start;
      continue;
    }
    ++passed;
    EXPECT_EQ(code, 3);
    EXPECT_NE(folder.read("err").find("particle 1 has gone through body 'leaf'"), std::string::npos)
        << folder.read("err");
  }
  EXPECT_GT(passed, 0);
}

TEST(WallHard, WorksWhereARankHasNoParticles) {
  const Folder folder;
  folder.write("paddle.stl", stl(paddle()));
  Law law;
  const std::string walls = ours("mesh part paddle.stl rotate part 0 0 0 0 0 1 rad/s 10 plane low 0 0 -0.02 0 0 1");
  const std::string end = particles({{0.03, 0.0035, 0, 0, 0, 0, 0.004}, {0.04, 0.005, 0, 0, 0, 0, 0.003}}) +
                          print_vector(18) + run(1000, 100);
  const auto one = frames_of(folder, deck(law) + walls + end);
  law.more = "processors 2 1 1\n";
  const auto two = frames_of(folder, deck(law) + walls + end, 2);
  EXPECT_LT(difference(one, two), 1e-12);
  EXPECT_GT(one.back().at(1).v[1], 0.1);
}

TEST(WallHard, WorksWhereTheBoxHasMoreTypesThanAnythingHas) {
  const Folder folder;
  const std::string end = ours("plane low 0 0 0 0 0 1") + particles({{0, 0, 0.002, 0, 0, -1, 0.004}}) + run(200, 20);
  Law more;
  more.types = 3;
  const auto two = frames_of(folder, deck({}) + end), three = frames_of(folder, deck(more) + end);
  EXPECT_EQ(0.0, difference(two, three));
  EXPECT_GT(three.back().at(1).v[2], 0.1) << "it has bounced";
}

}  // namespace
}  // namespace granary::dem::test
