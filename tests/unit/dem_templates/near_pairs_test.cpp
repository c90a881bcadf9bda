// Pairs of spheres that are near, and those of them that touch, against all pairs.
#include "dem_templates/plugin/lists/near_pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <utility>

#include "dem_templates/plugin/lists/cell_pairs.hpp"

namespace granary::dem {
namespace {

struct Spheres {
  std::vector<double> places, radii;

  /// In a box of sides [m], radii between the two.
  Spheres(std::size_t n, std::array<double, 3> box, double smallest, double largest) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (std::size_t i = 0; i < n; ++i) {
      for (const double side : box) places.push_back(side * unit(random) - 0.3);
      radii.push_back(smallest + (largest - smallest) * unit(random));
    }
  }
  std::size_t n() const { return radii.size(); }
  double gap(std::size_t i, std::size_t j, double factor = 1.0) const {
    return std::hypot(places[3 * i] - places[3 * j], places[3 * i + 1] - places[3 * j + 1],
                      places[3 * i + 2] - places[3 * j + 2]) -
           factor * (radii[i] + radii[j]);
  }
  void shake(double most) {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> way(-most / std::sqrt(3.0), most / std::sqrt(3.0));
    for (double& x : places) x += way(random);
  }
};

using Pairs = std::set<std::pair<int, int>>;

Pairs found(const Spheres& all, std::size_t n_own, double factor, double skin) {
  CellPairs cells;
  Pairs pairs;
  for (const auto& [i, j] : cells.find(all.places.data(), all.radii.data(), n_own, all.n(), factor, skin)) {
    EXPECT_LT(i, j);
    EXPECT_TRUE(pairs.insert({i, j}).second) << i << " " << j << " is there twice";
  }
  return pairs;
}

Pairs near(const Spheres& all, std::size_t n_own, double factor, double skin) {
  Pairs pairs;
  for (std::size_t i = 0; i < n_own; ++i)
    for (std::size_t j = i + 1; j < all.n(); ++j)
      if (all.gap(i, j, factor) <= skin) pairs.insert({static_cast<int>(i), static_cast<int>(j)});
  return pairs;
}

TEST(CellPairs, AreThoseOfAllPairsThatAreNear) {
  const struct {
    std::array<double, 3> box;
    double smallest, largest, factor, skin;
  } cases[] = {{{0.2, 0.05, 0.05}, 1e-3, 1e-3, 1.0, 1e-3},
               {{0.02, 0.02, 0.02}, 1e-4, 1e-3, 1.0, 2e-4},
               {{5.0, 5.0, 5.0}, 1e-3, 1e-3, 1.0, 1e-3},
               {{0.05, 0.05, 1e-9}, 1e-3, 2e-3, 1.1, 0.0},
               {{0.001, 0.001, 0.001}, 1e-3, 1e-3, 1.0, 0.0}};
  for (const auto& c : cases) {
    const Spheres all(600, c.box, c.smallest, c.largest);
    EXPECT_EQ(found(all, 600, c.factor, c.skin), near(all, 600, c.factor, c.skin));
    // Of two ghosts none is.
    EXPECT_EQ(found(all, 350, c.factor, c.skin), near(all, 350, c.factor, c.skin));
  }
}

TEST(CellPairs, AreNoneOfNothingAndOfWhatIsNoNumber) {
  EXPECT_TRUE(found(Spheres(0, {1, 1, 1}, 1, 1), 0, 1.0, 0.1).empty());
  Spheres all(50, {0.01, 0.01, 0.01}, 1e-3, 1e-3);
  all.places[10] = std::nan("");
  all.places[40] = std::numeric_limits<double>::infinity();
  const Pairs pairs = found(all, 50, 1.0, 1e-3);
  EXPECT_EQ(pairs, near(all, 50, 1.0, 1e-3));
  EXPECT_FALSE(pairs.empty());
  for (const auto& [i, j] : pairs) EXPECT_TRUE(i != 3 && j != 3 && i != 13 && j != 13);
}

TEST(NearPairs, MissNoneThatTouchesAfterAllHaveMovedBySoMuch) {
  const double skin = 2e-3;
  Spheres all(500, {0.05, 0.05, 0.05}, 0.5e-3, 2e-3);
  CellPairs cells;
  std::vector<NearPairs::Pair> listed;
  for (const auto& [i, j] : cells.find(all.places.data(), all.radii.data(), all.n(), all.n(), 1.0, skin))
    listed.push_back(
        {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), static_cast<std::uint32_t>(listed.size() % 5)});
  NearPairs near_pairs;
  near_pairs.start(listed, all.places.data(), all.radii.data(), skin);
  ASSERT_EQ(near_pairs.size(), listed.size());
  using Told = std::set<std::array<std::uint32_t, 3>>;
  for (const double moved : {0.0, 0.2e-3, 0.6e-3, 1e-3}) {
    Spheres now = all;
    now.shake(moved);
    Told touching;
    for (const auto& [i, j, place] : listed)
      if (now.gap(i, j) < 0.0) touching.insert({i, j, place});
    ASSERT_GT(touching.size(), 20u);
    for (const double said : {moved, std::numeric_limits<double>::infinity()}) {
      const std::span<const std::uint32_t> numbers = near_pairs.touching(now.places.data(), said);
      EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end()));
      Told told;
      for (const std::uint32_t number : numbers) {
        const auto& [i, j, place] = near_pairs.pair(number);
        told.insert({i, j, place});
      }
      EXPECT_EQ(told, touching);
      EXPECT_EQ(numbers.size(), touching.size());
    }
  }
}

}  // namespace
}  // namespace granary::dem
