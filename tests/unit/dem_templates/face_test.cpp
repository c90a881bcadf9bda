// Triangles of one plane as one face.
#include "dem_templates/plugin/wall/face.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

namespace granary::dem {
namespace {

constexpr double kFlatWithin = 1e-9;

/// n x n squares of side 1/n in two triangles each, which place(u, v) puts into space; those that keep(i, j).
std::vector<Triangle> sheet(int n, const std::function<Vector3(double, double)>& place,
                            const std::function<bool(int, int)>& keep) {
  std::vector<Triangle> triangles;
  const auto at = [&](int i, int j) { return place(static_cast<double>(i) / n, static_cast<double>(j) / n); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      if (!keep(i, j)) continue;
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return triangles;
}
bool all(int, int) { return true; }
Vector3 slanted(double u, double v) { return {u, v + 0.3 * u, 0.4 * u - 0.7 * v}; }

double area(const Triangle& t) { return 0.5 * norm(cross(t[1] - t[0], t[2] - t[0])); }

/// Faces that share out the triangles, each once, and have their areas and directions.
std::vector<Face> sound_faces(const std::vector<Triangle>& triangles) {
  const std::vector<Face> faces = faces_of(triangles, kFlatWithin);
  std::multiset<std::uint32_t> parts;
  for (const Face& face : faces) {
    parts.insert(face.triangles.begin(), face.triangles.end());
    const auto& c = face.corner;
    double sum = 0.0;
    for (const std::uint32_t t : face.triangles) sum += area(triangles[t]);
    EXPECT_NEAR(area({c[0], c[1], c[2]}) + area({c[0], c[2], c[3]}), sum, 1e-9);
    const Triangle& first = triangles[face.triangles[0]];
    EXPECT_GT(dot(cross(c[1] - c[0], c[2] - c[0]), cross(first[1] - first[0], first[2] - first[0])), 0.0);
  }
  EXPECT_EQ(parts.size(), triangles.size());
  EXPECT_EQ(std::set<std::uint32_t>(parts.begin(), parts.end()).size(), triangles.size());
  return faces;
}

TEST(Faces, OfAFlatAreOneHoweverFinelyItIsMeshed) {
  for (const int n : {1, 2, 3, 16}) EXPECT_EQ(sound_faces(sheet(n, slanted, all)).size(), 1u) << n;
  // A triangle in n^2 triangles.
  std::vector<Triangle> triangle;
  constexpr int kFine = 5;
  const auto at = [](int i, int j) { return slanted(static_cast<double>(i) / kFine, static_cast<double>(j) / kFine); };
  for (int i = 0; i < kFine; ++i)
    for (int j = 0; i + j < kFine; ++j) {
      triangle.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + j + 1 < kFine) triangle.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  const std::vector<Face> faces = sound_faces(triangle);
  ASSERT_EQ(faces.size(), 1u);
  EXPECT_TRUE(faces[0].is_triangle());
}

TEST(Faces, OfABentSheetEndWhereItBends) {
  const auto roof = [](double u, double v) { return Vector3{u, v, std::abs(u - 0.5)}; };
  EXPECT_EQ(sound_faces(sheet(8, roof, all)).size(), 2u);
  // Neighbours are flat within the tolerance, the whole is not.
  const auto bowl = [](double u, double v) { return Vector3{u, v, 1e-7 * u * u}; };
  for (const Face& face : sound_faces(sheet(64, bowl, all)))
    for (const Vector3& corner : face.corner)
      EXPECT_NEAR(dot(corner - face.corner[0], cross(face.corner[1] - face.corner[0], face.corner[2] - face.corner[0])),
                  0.0, kFlatWithin);
}

TEST(Faces, OfWhatIsNoConvexQuadrangleAreThoseOfItsTriangles) {
  const auto ell = [](int i, int j) { return i < 4 || j < 4; };
  const auto holed = [](int i, int j) { return i != 3 || j != 3; };
  const auto at_a_corner = [](int i, int j) { return (i < 4) == (j < 4); };
  EXPECT_GT(sound_faces(sheet(8, slanted, ell)).size(), 1u);
  EXPECT_GT(sound_faces(sheet(8, slanted, holed)).size(), 1u);
  EXPECT_EQ(sound_faces(sheet(8, slanted, at_a_corner)).size(), 2u);
  // The same flat twice, and once more the other way round.
  std::vector<Triangle> twice = sheet(2, slanted, all);
  const std::vector<Triangle> once = twice;
  twice.insert(twice.end(), once.begin(), once.end());
  EXPECT_GT(sound_faces(twice).size(), 1u);
  twice = once;
  for (const Triangle& t : once) twice.push_back({t[0], t[2], t[1]});
  EXPECT_GT(sound_faces(twice).size(), 1u);
}

}  // namespace
}  // namespace granary::dem
