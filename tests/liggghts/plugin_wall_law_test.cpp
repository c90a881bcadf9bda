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

}  // namespace
}  // namespace granary::dem::test
