// The flat faces of a surface: triangles, and what triangles of one plane are together. Meshes of machines are full of
// those, and a sphere has fewer faces to look at.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "dem_templates/plugin/resize/triangles.hpp"
#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {

struct Face {
  std::array<Vector3, 4> corner{};       ///< counterclockwise, convex; a triangle has its last one twice
  std::vector<std::uint32_t> triangles;  ///< numbers of those it is made of

  bool is_triangle() const { return corner[2] == corner[3]; }
};

/// All triangles that hang together in one plane as one face, if together they are a triangle or a convex quadrangle:
/// however finely a flat is meshed. Of other such regions each triangle alone or with a neighbour with which it makes a
/// convex quadrangle, longest shared sides first. By the order of their first triangles.
///
/// flat: a corner may be so far from the plane, or from the side, on which it lies [m].
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
