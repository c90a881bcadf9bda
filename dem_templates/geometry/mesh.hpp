// Triangle meshes of closed bodies: building, refining, checking. Pure geometry: no files, no LIGGGHTS.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace granary::dem {

struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;

  friend Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator*(double s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
  friend bool operator==(const Vec3&, const Vec3&) = default;
};
inline double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double length(Vec3 a) { return std::sqrt(dot(a, a)); }

using Corners = std::array<int, 3>;  ///< vertex numbers, counter-clockwise seen from outside the body's material

/// One or more closed bodies that share no vertex. [m]
struct Mesh {
  std::vector<Vec3> vertex;
  std::vector<Corners> triangle;
};

/// Adds the bodies of `other`.
void append(Mesh& mesh, const Mesh& other);

/// Volume by the divergence theorem: sum of a.(b x c)/6; positive if the triangles look outwards. [m^3]
double volume(const Mesh& mesh);

/// Each triangle in n^2 equal ones; flat faces stay flat, closed bodies stay closed.
Mesh refine(const Mesh& mesh, int n);

/// What keeps the mesh from being a set of closed, consistently oriented bodies: an edge that is not shared by exactly
/// two triangles of opposite direction, or a triangle without area. Nothing if it is closed. Vertices at the same place
/// must be the same vertex (see weld). The text names the place.
std::optional<std::string> defect(const Mesh& mesh);

/// Vertices nearer than `tolerance` become one [m].
Mesh weld(const Mesh& mesh, double tolerance);

struct Box3 {
  Vec3 low, high;
};
Box3 bounding_box(const Mesh& mesh);

}  // namespace granary::dem
