// Triangles in a grid of cells: which of them are near a point. For the resize, which asks often and moves no wall.
#pragma once

#include <array>
#include <vector>

#include "dem_templates/plugin/resize/free_space.hpp"
#include "dem_templates/plugin/resize/vector3.hpp"

namespace granary::dem {

using Triangle = std::array<Vector3, 3>;

/// The point of the triangle that is nearest to p. By regions of the triangle: C. Ericson, Real-Time
/// Collision Detection (2005), section 5.1.5.
Vector3 nearest_point(const Triangle& triangle, const Vector3& p);

/// Counterclockwise about it; of a triangle without area: zero.
Vector3 unit_normal(const Triangle& triangle);

class Triangles {
 public:
  /// reach: the largest distance that near() will be asked for [m], > 0.
  Triangles(std::vector<Triangle> triangles, double reach);
  /// Adds the triangles nearer than `reach` to point (at most the reach given at the start).
  void near(const Vector3& point, double reach, std::vector<NearWall>& found) const;
  std::size_t size() const { return triangles_.size(); }

 private:
  long cell_of(double coordinate, int axis) const;
  std::size_t index(long i, long j, long k) const;

  // Whether a point is further from a triangle's plane than `reach`: most are, and that costs little to know.
  bool plane_is_beyond(std::size_t triangle, const Vector3& point, double reach) const;

  std::vector<Triangle> triangles_;
  std::vector<Vector3> normals_;  ///< unit_normal() of each
  Vector3 low_{};
  double cell_size_ = 1.0;
  std::array<long, 3> n_cells_{0, 0, 0};
  std::vector<std::vector<int>> cells_;  ///< triangles whose boxes, widened by the reach, meet the cell
};

}  // namespace granary::dem
