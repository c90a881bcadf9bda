// Where spheres touch a mesh, held against looking at every triangle.
#include "dem_templates/plugin/wall/mesh_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "dem_templates/plugin/wall/watch.hpp"

namespace granary::dem {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
Vector3 anywhere(Random& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}

/// A ribbed sheet across x, fine and coarse, with some triangles flying about.
std::vector<Triangle> a_mesh(Random& random) {
  std::vector<Triangle> mesh;
  const auto at = [](int i, int j) { return Vector3{0.02 * std::sin(0.4 * i), -0.1 + 0.005 * i, -0.1 + 0.01 * j}; };
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 20; ++j) {
      mesh.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  for (int k = 0; k < 30; ++k) {
    const Vector3 corner = anywhere(random, 0.1);
    mesh.push_back({corner, corner + anywhere(random, 0.03), corner + anywhere(random, 0.03)});
  }
  return mesh;
}

double distance_by_hand(const std::vector<Triangle>& mesh, const Vector3& p) {
  double least = 1e300;
  for (const Triangle& triangle : mesh) least = std::min(least, norm(p - nearest_point(triangle, p)));
  return least;
}

Look look_at(Surface& surface, const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) {
  Look look{.centre = centre, .radius = radius, .nearby = &nearby};
  surface.look({&look, 1}, found);
  return look;
}

// Three sizes, 1:10 apart, fly about: slowly, so that what was listed serves for many looks, and so fast that nothing
// can be kept.
TEST(MeshSurface, FindsTheNearestPointOfEverySphereThatTouchesAndKeepsClearAsFarAsItSays) {
  Random random(4);
  const std::vector<Triangle> mesh = a_mesh(random);
  MeshSurface surface(mesh, 0.0);
  std::vector<SurfaceTouch> found;
  int touched = 0, clear = 0;
  for (const double radius : {0.001, 0.003, 0.01}) {
    for (const double step : {1e-5, 3e-4, 5e-3}) {
      for (int flight = 0; flight < 30; ++flight) {
        Vector3 place = anywhere(random, 0.1), way = anywhere(random, step);
        Nearby nearby;
        for (int k = 0; k < 40; ++k, place = place + way) {
          const double keeps = look_at(surface, place, radius, nearby, found).clear,
                       truth = distance_by_hand(mesh, place);
          ASSERT_LE(keeps, truth * (1 + 1e-9));
          if (truth >= radius) {
            ASSERT_TRUE(found.empty());
            ++clear;
            continue;
          }
          ++touched;
          ASSERT_FALSE(found.empty());
          ASSERT_NEAR(found[0].distance, truth, 1e-12);
          ASSERT_NEAR(norm(place - found[0].point), truth, 1e-12);
          ASSERT_NEAR(norm(found[0].point - nearest_point(mesh[surface.part_at(found[0])], place)), 0.0, 1e-12);
        }
      }
    }
  }
  EXPECT_GT(touched, 500);
  EXPECT_GT(clear, 500);
}

TEST(MeshSurface, SaysTheSameWhateverItRemembers) {
  Random random(5);
  const std::vector<Triangle> mesh = a_mesh(random);
  MeshSurface surface(mesh, 0.1);
  std::vector<SurfaceTouch> with, without;
  Nearby nearby;
  Vector3 place{0.0, 0.0, 0.0};
  for (int k = 0; k < 4000; ++k) {
    place = place + anywhere(random, 4e-4);
    look_at(surface, place, 0.004, nearby, with);
    Nearby nothing;
    look_at(surface, place, 0.004, nothing, without);
    ASSERT_EQ(with.size(), without.size()) << k;
    for (std::size_t n = 0; n < with.size(); ++n) {
      ASSERT_EQ(with[n].face, without[n].face);
      ASSERT_EQ(with[n].distance, without[n].distance);
    }
  }
}

// Of all sizes, near and far, at places that many faces are close to as well.
TEST(MeshSurface, SaysTheSameOfManyAtOnceAsOfEachAlone) {
  Random random(7);
  const std::vector<Triangle> mesh = a_mesh(random);
  MeshSurface surface(mesh, 0.1);
  std::size_t touches = 0, of_many_faces = 0;
  for (int round = 0; round < 20; ++round) {
    std::vector<Look> looks(1 + 13 * static_cast<std::size_t>(round));
    std::vector<Nearby> nearby(looks.size());
    for (std::size_t k = 0; k < looks.size(); ++k)
      looks[k] = {.centre = anywhere(random, 0.1), .radius = uniform(random, 0.0005, 0.03), .nearby = &nearby[k]};
    std::vector<SurfaceTouch> together, alone;
    surface.look(looks, together);
    for (const Look& look : looks) {
      Nearby nothing;
      const Look by_itself = look_at(surface, look.centre, look.radius, nothing, alone);
      ASSERT_EQ(look.n, alone.size());
      ASSERT_EQ(look.clear, by_itself.clear);
      for (std::size_t n = 0; n < look.n; ++n) {
        const SurfaceTouch& touch = together[look.first + n];
        ASSERT_EQ(touch.face, alone[n].face);
        ASSERT_EQ(touch.distance, alone[n].distance);
        ASSERT_EQ(touch.normal, alone[n].normal);
        ASSERT_EQ(touch.point, alone[n].point);
      }
      touches += look.n;
      of_many_faces += look.n > 2 ? 1 : 0;
    }
  }
  EXPECT_GT(touches, 200u);
  EXPECT_GT(of_many_faces, 10u);
}

TEST(MeshSurface, KnowsWhatLiesAcrossAWay) {
  const std::vector<Triangle> leaf{{{{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}}}};
  const MeshSurface surface(leaf, 0.0);
  EXPECT_TRUE(surface.between({0.002, 0.002, 0.01}, {0.003, 0.002, -0.02}));
  EXPECT_FALSE(surface.between({0.002, 0.002, 0.01}, {0.003, 0.002, 0.001}));
  EXPECT_FALSE(surface.between({0.02, 0.002, 0.01}, {0.02, 0.002, -0.02}));
}

// A body at 2000 rad/s, particles that fly about: whoever touches is due, and most that do not are not.
TEST(Watch, NeverMissesAParticleThatTouches) {
  Random random(6);
  const std::vector<Triangle> mesh = a_mesh(random);
  WallBody body;
  body.surface = std::make_unique<MeshSurface>(mesh, 0.0);
  body.rotation = {{0.01, 0.0, 0.0}, {0, 0, 1}, 2000.0};
  body.start(0, 5e-6);
  const double radius = 0.002;
  std::vector<Vector3> places(150), ways(150);
  for (std::size_t i = 0; i < places.size(); ++i) {
    places[i] = anywhere(random, 0.13);
    ways[i] = anywhere(random, i % 2 ? 1e-5 : 2e-4);
  }
  Watch watch;
  watch.resize(places.size());
  std::vector<SurfaceTouch> found;
  int looks = 0, touched = 0;
  for (long step = 0; step < 60; ++step) {
    body.turn_to(step);
    std::vector<bool> looked(places.size(), false);
    for (const std::uint32_t i : watch.due(body, places[0].data(), places.size())) {
      const Vector3 here = body.to_body(places[i]);
      const Look look = look_at(*body.surface, here, radius, watch.nearby(i), found);
      watch.looked(i, here, radius, look.clear, look.n);
      looked[i] = true;
      ++looks;
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (distance_by_hand(mesh, body.to_body(places[i])) < radius) {
        ++touched;
        ASSERT_TRUE(looked[i]) << i << " at step " << step;
      }
      places[i] = places[i] + ways[i];
    }
  }
  EXPECT_GT(touched, 50);
  EXPECT_LT(looks, 150 * 60 / 2);
}

}  // namespace
}  // namespace granary::dem
