// Where granary/wall pushes: once for each patch that a particle leans on, with real LIGGGHTS.
#include "tests/liggghts/wall_deck.hpp"

namespace granary::dem::test {
namespace {

TEST(Wall, LetsAParticleSlideAndRollOverSeamsWithoutABump) {
  const Folder folder;
  folder.write("two.stl", stl(floor_of(1)));
  folder.write("many.stl", stl(floor_of(40)));
  const Law law{.models = "rolling_friction epsd2"};
  const std::string end = particles({{-0.03, -0.03, 0.001999, 0.8, 0.5, 0, 0.004},
                                     {-0.03, 0.0, 0.001999, 0.9, 0, 0, 0.004},
                                     {0.01, 0.0101, 0.001999, 0, -0.6, 0, 0.004}}) +
                          run(8000, 10);

  const auto plane = frames_of(folder, deck(law) + ours("plane floor 0 0 0 0 0 1", law) + end);
  const auto two = frames_of(folder, deck(law) + ours("mesh floor two.stl", law) + end);
  const auto many = frames_of(folder, deck(law) + ours("mesh floor many.stl", law) + end);

  EXPECT_LT(difference(two, plane), 1e-10);
  EXPECT_LT(difference(many, plane), 1e-10);
  EXPECT_GT(plane.back().at(1).x[0], -0.01);  // it did travel: over eight seams of the fine floor and more
}

/// Force on a sphere of radius 2 mm that rests at `place` beside the mesh, at the first step.
Point force_at(const std::vector<Corners>& mesh, const Point& place, double diameter = 0.004) {
  const Folder folder;
  folder.write("part.stl", stl(mesh));
  const auto frames = frames_of(folder, deck({.gravity = 0.0}) + ours("mesh part part.stl") +
                                            particles({{place[0], place[1], place[2], 0, 0, 0, diameter}}) + run(0, 1));
  return frames.back().at(1).force;
}

TEST(Wall, PushesFromAnEdgeAndFromAVertexOnceTowardsTheCentre) {
  for (const int n : {1, 4}) {
    const auto cube = box({-0.01, -0.01, -0.01}, {0, 0, 0}, n);
    const double radius = 0.002, overlap = 0.0001, off = radius - overlap;

    const double edge = off / std::sqrt(2.0), push = hertz(radius, overlap);
    const Point at_edge = force_at(cube, {edge, edge, -0.00361});
    EXPECT_NEAR(at_edge[0], push / std::sqrt(2.0), 1e-9 * push);
    EXPECT_NEAR(at_edge[1], push / std::sqrt(2.0), 1e-9 * push);
    EXPECT_NEAR(at_edge[2], 0.0, 1e-9 * push);

    const double vertex = off / std::sqrt(3.0);
    const Point at_vertex = force_at(cube, {vertex, vertex, vertex});
    for (double f : at_vertex) EXPECT_NEAR(f, push / std::sqrt(3.0), 1e-9 * push);

    const Point at_face = force_at(cube, {off, -0.0025, -0.0025});  // n = 4: where four cells meet
    EXPECT_NEAR(at_face[0], push, 1e-9 * push);
    EXPECT_NEAR(std::hypot(at_face[1], at_face[2]), 0.0, 1e-9 * push);
  }
}

// Deep enough to reach over seams and over the edge of the body: their triangles are not touched beside the face.
TEST(Wall, PushesOnceBesideSeamsAndEdges) {
  const double radius = 0.002, overlap = 1e-4, push = hertz(radius, overlap);
  for (const double beside : {0.1e-3, 0.3e-3, 0.5e-3}) {
    const auto fine = sheet({-0.012, -0.012, 0}, {0.024, 0, 0}, {0, 0.024, 0}, 24);
    const Point on_sheet = force_at(fine, {0.002 + beside, 0.001 + 0.5 * beside, radius - overlap});
    EXPECT_NEAR(on_sheet[2], push, 1e-9 * push) << beside;
    EXPECT_NEAR(std::hypot(on_sheet[0], on_sheet[1]), 0.0, 1e-9 * push) << beside;
    const Point by_edge = force_at(box({-0.01, -0.01, -0.01}, {0, 0, 0}, 2), {-beside, -0.0031, radius - overlap});
    EXPECT_NEAR(by_edge[2], push, 1e-9 * push) << beside;
    EXPECT_NEAR(std::hypot(by_edge[0], by_edge[1]), 0.0, 1e-9 * push) << beside;
  }
}

TEST(Wall, PushesFromBothFacesOfACorner) {
  auto corner = sheet({0, 0, 0}, {0.02, 0, 0}, {0, 0.02, 0}, 3);
  const auto wall = sheet({0, 0, 0}, {0, 0.02, 0}, {0, 0, 0.02}, 3);
  corner.insert(corner.end(), wall.begin(), wall.end());
  const double radius = 0.002;
  const Point force = force_at(corner, {radius - 1e-4, 0.01, radius - 2e-4});
  EXPECT_NEAR(force[0], hertz(radius, 1e-4), 1e-9 * force[0]);
  EXPECT_NEAR(force[2], hertz(radius, 2e-4), 1e-9 * force[2]);
  EXPECT_NEAR(force[1], 0.0, 1e-12);
}

TEST(Wall, PushesOnceFromAFinelyMeshedRoundWall) {
  std::vector<Corners> drum;
  const int n = 360;
  const double inner = 0.03;
  for (int k = 0; k < n; ++k) {
    const double a = 2 * kPi * k / n, b = 2 * kPi * (k + 1) / n;
    const auto strip =
        sheet({inner * std::cos(a), inner * std::sin(a), -0.02},
              {inner * (std::cos(b) - std::cos(a)), inner * (std::sin(b) - std::sin(a)), 0}, {0, 0, 0.04});
    drum.insert(drum.end(), strip.begin(), strip.end());
  }
  const double radius = 0.002, overlap = 1e-4, off = inner - radius + overlap;
  const double push = hertz(radius, overlap);
  for (const double angle : {0.0, 0.3 * kPi / n, kPi / n}) {
    const Point force = force_at(drum, {off * std::cos(angle), off * std::sin(angle), 0.001});
    EXPECT_NEAR(length(force), push, 0.03 * push) << angle;
  }
}

TEST(Wall, MeetsAThinBladeFromBothSidesAndOnlyOnce) {
  const double radius = 0.002, overlap = 3e-4, off = radius - overlap, push = hertz(radius, overlap);
  const auto leaf = sheet({-0.01, -0.01, 0}, {0.02, 0, 0}, {0, 0.02, 0}, 2);
  const double half = 5e-5;  // thinner than the overlap is deep
  const auto blade = box({-0.01, -0.01, -half}, {0.01, 0.01, half}, 2);
  for (const double side : {1.0, -1.0}) {
    EXPECT_NEAR(force_at(leaf, {0.003, 0.001, side * off})[2], side * push, 1e-9 * push);
    EXPECT_NEAR(force_at(blade, {0.003, 0.001, side * (off + half)})[2], side * push, 1e-9 * push);
    EXPECT_NEAR(force_at(blade, {0.0, 0.0, side * (off + half)})[2], side * push, 1e-9 * push);
  }
  // A wedge whose faces are 20 degrees apart: its far face is hidden by the near one.
  const double slope = std::tan(20.0 * kPi / 180.0);
  auto wedge = sheet({0, -0.01, 0}, {0.02, 0, 0}, {0, 0.02, 0});
  const auto below = sheet({0, -0.01, 0}, {0.02, 0, -0.02 * slope}, {0, 0.02, 0});
  wedge.insert(wedge.end(), below.begin(), below.end());
  const Point force = force_at(wedge, {0.001, 0.0, off});
  EXPECT_NEAR(force[2], push, 1e-9 * push);
  EXPECT_NEAR(force[0], 0.0, 1e-9 * push);
}

}  // namespace
}  // namespace granary::dem::test
