// A surface of triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "dem_templates/plugin/wall/surface.hpp"
#include "dem_templates/plugin/wall/triangle_cells.hpp"

namespace granary::dem {

/// Triangles, closed or not.
///
/// A touch is a local minimum of the distance from the centre over the surface, that the centre sees. So a shared edge
/// or vertex counts only where no triangle at it comes nearer, a flat seam gives what the whole face would, and
/// neither the far side of a thin blade nor what is buried in another part counts. Touches whose normals differ by less
/// than `smooth` are one, the nearest: a round wall made of small flats pushes once.
class MeshSurface : public Surface {
 public:
  /// At least one triangle, each with an area. smooth: [rad].
  MeshSurface(std::vector<Triangle> triangles, double smooth);
  double touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) override;
  bool between(const Vector3& from, const Vector3& to) const override;
  double farthest_from(const Vector3& origin, const Vector3& unit_axis) const override;
  std::size_t n_parts() const override { return triangles_.size(); }
  std::vector<Triangle> triangles() const override { return triangles_; }

 private:
  /// The plane of a triangle: many candidates are too far from it, so it is kept apart from the rest.
  struct Plane {
    Vector3 normal;
    double offset;  ///< of the plane along the normal [m]
  };
  /// Barycentric coordinates of p, as dot(p, to_b) - b: below 0 by as many times as `heights` (of the corners a, b, c
  /// over their sides) as p lies beyond that side.
  struct Face {
    Vector3 to_b, to_c;
    double b, c;
    Vector3 heights;
  };
  struct Candidate {
    SurfaceTouch touch;
    bool inside = false;  ///< nearest point in the inside of the triangle, not on its rim
  };

  double height(std::uint32_t triangle, const Vector3& p) const {
    return dot(p, planes_[triangle].normal) - planes_[triangle].offset;
  }
  /// Distance of p, in the triangle's plane, from the farthest side that it is beyond of; not above 0 inside. No point
  /// of the triangle is nearer.
  double beyond(std::uint32_t triangle, const Vector3& p) const;
  bool contains(std::uint32_t triangle, const Vector3& p) const;
  /// Lists the nearest triangles.
  void search(const Vector3& centre, const TriangleCells::Near& near, Nearby& nearby) const;
  /// Fills near_ with the triangles that touch; returns a distance that the surface keeps from the centre for certain.
  double find_touching(const Vector3& centre, double radius, Nearby& nearby);
  bool comes_nearer_elsewhere(const Candidate& candidate) const;
  bool hidden(const Vector3& centre, const Candidate& candidate) const;

  std::vector<Triangle> triangles_;
  std::vector<Plane> planes_;
  std::vector<Face> faces_;
  double same_point_ = 0.0;  ///< points nearer than this are one: the digits of an STL file [m]
  double rounding_ = 0.0;    ///< of a list of what is near, in single precision [m]
  double same_direction_;    ///< cosine

  TriangleCells cells_;
  double largest_radius_ = 0.0;  ///< that the cells are good for; they are made anew for a larger one [m]

  std::vector<Candidate> near_;  ///< scratch
};

}  // namespace granary::dem
