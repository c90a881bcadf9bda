// The surface of a body, in the body's own frame: where spheres touch it. Pure geometry, built once.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "dem_templates/plugin/resize/triangles.hpp"
#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {

struct SurfaceTouch {
  double distance = 0.0;  ///< from the sphere's centre to the surface, below its radius [m]
  Vector3 point{};        ///< of the surface, the nearest
  Vector3 normal{};       ///< unit vector from there to the centre
};

/// What was near a sphere's centre when it was last searched for: good until the centre has moved too far. Starts empty
/// and costs only time when it is lost.
struct Nearby {
  static constexpr std::size_t kMost = 15;

  Vector3 place{};        ///< of the centre then
  double complete = 0.0;  ///< everything nearer to that place is listed [m]
  std::uint32_t n = 0;
  std::array<std::uint32_t, kMost> triangle;
};

class Surface {
 public:
  virtual ~Surface() = default;
  /// Sets `found` to the touches of a sphere, nearest first: one for each patch of the surface it leans on. Returns a
  /// distance that the surface keeps from the centre for certain [m]: the centre need not be looked at again before it
  /// has moved by that less the radius.
  virtual double touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) = 0;
  /// Largest distance of a point of it from an axis [m]; 0 for endless surfaces.
  virtual double farthest_from(const Vector3& /*origin*/, const Vector3& /*unit_axis*/) const { return 0.0; }
  /// What it is made of; nothing if it is no mesh.
  virtual std::vector<Triangle> triangles() const { return {}; }
};

/// An endless plane with two sides.
class PlaneSurface : public Surface {
 public:
  PlaneSurface(const Vector3& point, const Vector3& unit_normal) : point_(point), normal_(unit_normal) {}
  double touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) override;

 private:
  Vector3 point_, normal_;
};

/// An endless cylinder; touched from inside and from outside.
class CylinderSurface : public Surface {
 public:
  CylinderSurface(const Vector3& point, const Vector3& unit_axis, double radius)
      : point_(point), axis_(unit_axis), radius_(radius) {}
  double touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) override;

 private:
  Vector3 point_, axis_;
  double radius_;
};

/// Triangles, closed or not, in a grid of cells that knows which of them a sphere in the cell can touch.
///
/// A touch is a local minimum of the distance from the centre over the surface, that the centre sees. So a shared edge
/// or vertex counts only where no triangle at it comes nearer, a flat seam gives what the whole face would, and
/// neither the far side of a thin blade nor what is buried in another part counts. Touches whose normals differ by less
/// than `smooth` are one, the nearest: a round wall made of small flats pushes once.
class MeshSurface : public Surface {
 public:
  /// smooth: [rad].
  MeshSurface(std::vector<Triangle> triangles, double smooth);
  double touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) override;

  double farthest_from(const Vector3& origin, const Vector3& unit_axis) const override;
  std::vector<Triangle> triangles() const override { return triangles_; }

 private:
  /// The plane of a triangle: most candidates are too far from it, so it is kept apart from the rest.
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
    std::uint32_t triangle = 0;
    bool inside = false;  ///< nearest point in the inside of the triangle, not on its rim
  };

  void build_cells(double reach);
  /// Triangles of the cell that the centre is in.
  std::span<const std::uint32_t> cell_at(const Vector3& centre) const;
  /// Those of them that may be nearer than the reach, or as many of the nearest as can be listed.
  void search(const Vector3& centre, std::span<const std::uint32_t> cell, Nearby& nearby) const;
  double least_distance2(std::uint32_t triangle, const Vector3& point) const;
  bool comes_nearer_elsewhere(const Candidate& candidate) const;
  bool hidden(const Vector3& centre, const Candidate& candidate) const;
  std::size_t cell_index(long i, long j, long k) const {
    return static_cast<std::size_t>((i * n_cells_[1] + j) * n_cells_[2] + k);
  }

  std::vector<Triangle> triangles_;
  std::vector<Plane> planes_;
  std::vector<Face> faces_;
  double same_point_ = 0.0;  ///< points nearer than this are one: the digits of an STL file [m]
  double same_direction_;    ///< cosine

  double largest_radius_ = 0.0;  ///< that the cells are good for; they are made anew for a larger one [m]
  double reach_ = 0.0;           ///< a cell's list has all triangles nearer than this to any point of it [m]
  Vector3 low_{};
  double cell_size_ = 1.0;
  std::array<long, 3> n_cells_{};
  std::vector<std::uint32_t> first_, entries_;  ///< triangles of cell c: entries first_[c] to first_[c + 1]

  std::vector<Candidate> near_;  ///< scratch
};

}  // namespace granary::dem
