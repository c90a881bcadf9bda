// The surface of a body, in the body's own frame: where spheres touch it. Pure geometry, built once.
#pragma once

#include <cstdint>
#include <span>
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

/// Where a sphere touches a surface: what is asked, and what was found.
struct Look {
  Vector3 centre{};  ///< in the body's frame
  double radius = 0.0;
  Nearby* nearby = nullptr;  ///< of this sphere and this surface
  std::uint32_t particle = 0;

  std::uint32_t first = 0, n = 0;  ///< its touches among those found, nearest first
  double clear = 0.0;  ///< The surface keeps so far from the centre for certain [m]: the sphere need not be looked at
                       ///< again before its centre has moved by this less its radius.
};

class Surface {
 public:
  virtual ~Surface() = default;
  /// Sets `found` to the touches of all looks: of each sphere one for each patch of the surface it leans on. Many at
  /// once cost less each.
  virtual void look(std::span<Look> looks, std::vector<SurfaceTouch>& found) = 0;
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
