// How granary/wall pushes, against LIGGGHTS' own walls and against exact results, with real LIGGGHTS.
#include "tests/liggghts/wall_deck.hpp"

namespace granary::dem::test {
namespace {

TEST(Wall, PushesAsTheStockPlaneAndTheStockMeshWithEveryModel) {
  for (const std::string rolling : {"", " rolling_friction epsd2", " rolling_friction cdt"}) {
    for (const std::string cohesion : {"", "cohesion sjkr"}) {
      const Folder folder;
      folder.write("floor.stl", stl(floor_of(1)));
      const Law law{.models = cohesion + rolling};
      const std::string end = falling() + run(6000, 20);

      const auto mine = frames_of(folder, deck(law) + ours("mesh floor floor.stl", law) + end);
      const auto plane = frames_of(folder, deck(law) + stock_plane(law) + end);
      const auto mesh = frames_of(folder, deck(law) + stock_mesh("floor.stl", law) + end);

      EXPECT_LT(difference(mine, plane), 1e-11) << law.models;
      EXPECT_LT(difference(mine, mesh), 1e-11) << law.models;
      EXPECT_GT(std::abs(mine.back().at(2).spin[1]), 1.0);
    }
  }
}

TEST(Wall, GivesBackTheStatedShareOfTheNormalSpeed) {
  for (const double restitution : {0.3, 0.6, 0.9}) {
    for (const double speed : {0.1, 1.0, 5.0}) {
      const Folder folder;
      const Law law{.restitution = restitution, .gravity = 0.0};
      const auto frames = frames_of(folder, deck(law) + ours("plane floor 0 0 0 0 0 1") +
                                                particles({{0, 0, 0.0021, 0, 0, -speed, 0.004}}) + run(1500, 1500));
      EXPECT_NEAR(frames.back().at(1).v[2], restitution * speed, 0.02 * speed) << restitution << " at " << speed;
    }
  }
}

// Sliding impact: the tangential impulse is mu (1 + e) m v_n (Johnson, Contact Mechanics, 11.6 (b)).
TEST(Wall, ChangesTheTangentialSpeedOfASlidingImpactByCoulombsShare) {
  const Folder folder;
  const double normal = 1.0, along = 20.0, friction = 0.3;
  const Law law{.restitution = 0.8, .friction = friction, .gravity = 0.0};
  const auto frames = frames_of(folder, deck(law) + ours("plane floor 0 0 0 0 0 1") +
                                            particles({{-0.03, 0, 0.0021, along, 0, -normal, 0.004}}) + run(500, 500));
  const State& after = frames.back().at(1);
  const double lost = along - after.v[0];
  EXPECT_NEAR(lost, friction * (normal + after.v[2]), 0.02 * lost);
  EXPECT_NEAR(after.spin[1], 2.5 * lost / 0.002, 0.06 * after.spin[1]);
}

}  // namespace
}  // namespace granary::dem::test
