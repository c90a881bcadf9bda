// The surface of a body, in the body's own frame: where spheres touch it. Pure geometry, built once.
#pragma once

#include <cstdint>
#include <vector>

#include "dem_templates/plugin/resize/triangles.hpp"
#include "dem_templates/plugin/wall/nearby.hpp"
#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {

struct SurfaceTouch {
  double distance = 0.0;   ///< from the sphere's centre to the surface, below its radius [m]
  Vector3 point{};         ///< of the surface, the nearest
  Vector3 normal{};        ///< unit vector from there to the centre
  std::uint32_t face = 0;  ///< number of the face it lies in
};

class Surface {
 public:
  virtual ~Surface() = default;
  /// Sets `found` to the touches of a sphere, nearest first: one for each patch of the surface it leans on. Returns a
  /// distance that the surface keeps from the centre for certain [m]: the centre need not be looked at again before it
  /// has moved by that less the radius.
  virtual double touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) = 0;
  /// Whether the surface lies across the way from one point to the other.
  virtual bool between(const Vector3& from, const Vector3& to) const = 0;
  /// Largest distance of a point of it from an axis [m]; 0 for endless surfaces.
  virtual double farthest_from(const Vector3& /*origin*/, const Vector3& /*unit_axis*/) const { return 0.0; }
  /// Number of triangles; 0 if it is no mesh.
  virtual std::size_t n_parts() const { return 0; }
  /// Number of the triangle that is touched.
  virtual std::size_t part_at(const SurfaceTouch& /*touch*/) const { return 0; }
  /// What it is made of; nothing if it is no mesh.
  virtual std::vector<Triangle> triangles() const { return {}; }
};

}  // namespace granary::dem
