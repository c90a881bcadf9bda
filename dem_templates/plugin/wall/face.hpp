// The flat faces of a surface: triangles, and pairs of triangles that lie in one plane. Meshes of machines are full of
// those, and a sphere has half as many faces to look at.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dem_templates/plugin/resize/triangles.hpp"
#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {

struct Face {
  std::array<Vector3, 4> corner{};          ///< counterclockwise, convex; a triangle has its last one twice
  std::array<std::uint32_t, 2> triangle{};  ///< numbers of (0 1 2) and (0 2 3); of a triangle twice the same

  bool is_triangle() const { return triangle[0] == triangle[1]; }
};

/// Each triangle alone or with a neighbour: one with which it shares a side, is coplanar and makes a convex whole.
/// Longest sides first, so that the halves of a rectangle find each other. By the order of their first triangles.
///
/// flat: a corner of the one may be so far from the plane of the other [m].
std::vector<Face> faces_of(std::span<const Triangle> triangles, double flat);

/// The point of the face that is nearest to p.
Vector3 nearest_point(const Face& face, const Vector3& p);

/// Sides of triangles by their ends, which must be the very same numbers, as STL files have them.
struct SharedSide {
  Vector3 low, high;
  std::uint32_t owner, side;
};
/// Sorted so that those with the same ends follow each other, by owner.
void sort_by_ends(std::vector<SharedSide>& sides);
inline bool same_ends(const SharedSide& a, const SharedSide& b) { return a.low == b.low && a.high == b.high; }

}  // namespace granary::dem
