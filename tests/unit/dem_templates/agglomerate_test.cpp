// Agglomerates: packed, read, written and placed.
#include "dem_templates/plugin/bond/agglomerate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace granary::dem {
namespace {

/// A cube of 40 mm with a wall through its middle.
class Halves : public FreeSpace {
 public:
  bool inside(const Vector3& p) const override {
    return std::abs(p[0]) < 0.02 && std::abs(p[1]) < 0.02 && std::abs(p[2]) < 0.02;
  }
  void walls_near(const Vector3& p, double reach, std::vector<NearWall>& found) const override {
    for (std::size_t d = 0; d < 3; ++d)
      if (0.02 - std::abs(p[d]) < reach) found.push_back({0.02 - std::abs(p[d]), {}});
    if (std::abs(p[0]) < reach) found.push_back({std::abs(p[0]), {}});
  }
  Vector3 low() const override { return {-0.02, -0.02, -0.02}; }
  Vector3 high() const override { return {0.02, 0.02, 0.02}; }
};

double smallest_gap(const Agglomerate& a, const Agglomerate& b) {
  double smallest = 1.0;
  for (const auto& one : a)
    for (const auto& other : b)
      if (&one != &other) smallest = std::min(smallest, norm(one.centre - other.centre) - one.radius - other.radius);
  return smallest;
}

TEST(Agglomerate, Packs37SpheresOf1200MicrometresInAboutFiveMillimetres) {
  const Agglomerate packed = pack_ball(37, 1.2e-3, 5e-3, 7);
  ASSERT_EQ(packed.size(), 37u);
  EXPECT_NEAR(agglomerate_diameter(packed), 5e-3, 0.15e-3);
  EXPECT_GT(solid_fraction(packed), 0.46);
  EXPECT_GE(smallest_gap(packed, packed), 0.0);
  int near = 0;  // pairs that a gap of a twentieth of the diameter bonds
  for (std::size_t a = 0; a < packed.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) near += norm(packed[a].centre - packed[b].centre) < 1.26e-3 ? 1 : 0;
  EXPECT_GT(near, 80);
}

TEST(Agglomerate, PacksTheSameForTheSameSeed) {
  const Agglomerate one = pack_ball(20, 1e-3, 4e-3, 3), again = pack_ball(20, 1e-3, 4e-3, 3);
  const Agglomerate other = pack_ball(20, 1e-3, 4e-3, 4);
  EXPECT_EQ(one[7].centre, again[7].centre);
  EXPECT_NE(one[7].centre, other[7].centre);
}

TEST(Agglomerate, GrowsTheBallIntoWhichTheSpheresDoNotFit) {
  const Agglomerate packed = pack_ball(13, 1e-3, 1e-3, 1);
  EXPECT_GE(smallest_gap(packed, packed), 0.0);
  EXPECT_NEAR(agglomerate_diameter(packed), 3.2e-3, 0.4e-3);  // twelve around one: 3 mm
}

TEST(Agglomerate, OneSphereIsAnAgglomerate) {
  const Agglomerate packed = pack_ball(1, 1e-3, 1e-3, 1);
  EXPECT_EQ(packed.size(), 1u);
  EXPECT_DOUBLE_EQ(agglomerate_diameter(packed), 1e-3);
  EXPECT_DOUBLE_EQ(solid_fraction(packed), 1.0);
}

TEST(Agglomerate, PlacesWholeCopiesClearOfWallsAndOfEachOther) {
  const Halves space;
  const Agglomerate shape = pack_ball(20, 1.2e-3, 4.2e-3, 3), there{{{0.01, 0.01, 0.01}, 0.004}};
  const auto placed = place_agglomerates({shape}, space, there, {.count = 60, .seed = 9});
  ASSERT_TRUE(placed.has_value()) << placed.error().message;
  ASSERT_EQ(placed->size(), 60u);
  std::vector<NearWall> walls;
  for (std::size_t a = 0; a < placed->size(); ++a) {
    const Agglomerate& one = (*placed)[a];
    EXPECT_NEAR(agglomerate_diameter(one), agglomerate_diameter(shape), 1e-12);  // turned and moved, not bent
    EXPECT_GE(smallest_gap(one, there), 0.0);
    for (std::size_t b = 0; b < a; ++b) EXPECT_GE(smallest_gap(one, (*placed)[b]), 0.0);
    for (const auto& sphere : one) {
      EXPECT_TRUE(space.inside(sphere.centre));
      space.walls_near(sphere.centre, sphere.radius, walls);
    }
  }
  EXPECT_TRUE(walls.empty());
}

TEST(Agglomerate, TakesTheShapesInTurns) {
  const auto placed = place_agglomerates({pack_ball(2, 1e-3, 2e-3, 1), pack_ball(5, 1e-3, 3e-3, 1)}, Halves(), {},
                                         {.count = 5, .seed = 1});
  ASSERT_TRUE(placed.has_value());
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ((*placed)[k].size(), k % 2 ? 5u : 2u);
}

TEST(Agglomerate, SaysForHowManyThereIsRoom) {
  const auto placed = place_agglomerates({pack_ball(1, 0.015, 0.015, 1)}, Halves(), {}, {.count = 50, .tries = 500});
  ASSERT_FALSE(placed.has_value());
  EXPECT_NE(placed.error().message.find("of the 50 agglomerates only"), std::string::npos) << placed.error().message;
}

TEST(Agglomerate, ReadsBackWhatItWroteAndNamesWhatIsWrong) {
  const auto file = std::filesystem::temp_directory_path() / "granary-agglomerates-test.json";
  const std::vector<Agglomerate> some{pack_ball(3, 1e-3, 3e-3, 1), pack_ball(4, 1e-3, 3e-3, 2)};
  ASSERT_TRUE(write_agglomerates(file, some).has_value());
  const auto read = read_agglomerates(file);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ((*read)[1][3].centre, some[1][3].centre);
  EXPECT_EQ((*read)[1][3].radius, some[1][3].radius);

  const auto says = [&](const std::string& text, const std::string& said) {
    std::ofstream(file) << text;
    const auto wrong = read_agglomerates(file);
    ASSERT_FALSE(wrong.has_value()) << text;
    EXPECT_NE(wrong.error().message.find(said), std::string::npos) << wrong.error().message;
  };
  const std::string format = R"({"format": "granary-agglomerates-1", "agglomerates": )";
  says("{}", "/format must be");
  says(format + "[]}", "at least one agglomerate");
  says(format + R"([{"spheres_m": []}]})", "/agglomerates/0/spheres_m must list at least one sphere");
  says(format + R"([{"spheres_m": [[0, 0, 0, 1e-3], [0, 0, 1e-3]]}]})", "/agglomerates/0/spheres_m/1 must be");
  says(format + R"([{"spheres_m": [[0, 0, 0, -1e-3]]}]})", "the radius > 0");
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace granary::dem
