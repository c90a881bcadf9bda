// Spheres in a free space: how much they overlap, and pushing them apart.
#pragma once

#include <cstddef>
#include <vector>

#include "dem_templates/plugin/resize/free_space.hpp"
#include "dem_templates/plugin/resize/vector3.hpp"

namespace granary::dem {

struct Sphere {
  Vector3 centre{};
  double radius = 0.0;                       ///< [m]
  double axial_low = 0.0, axial_high = 0.0;  ///< its centre stays between these places along the axis [m]
};

/// Finds the spheres near a point; points are added and moved by hand.
class SphereGrid {
 public:
  /// reach: the largest distance between centres that is asked for [m].
  SphereGrid(const Vector3& low, const Vector3& high, double reach);
  void add(int sphere, const Vector3& centre);
  void remove(int sphere, const Vector3& centre);  // that it was added with
  /// Calls found(sphere) for each sphere in the cells around a point: all within reach, and some beyond.
  template <class Found>
  void around(const Vector3& point, Found&& found) const {
    const Cell c = cell_of(point);
    for (long i = c.i > 0 ? c.i - 1 : 0; i <= c.i + 1 && i < n_[0]; ++i)
      for (long j = c.j > 0 ? c.j - 1 : 0; j <= c.j + 1 && j < n_[1]; ++j)
        for (long k = c.k > 0 ? c.k - 1 : 0; k <= c.k + 1 && k < n_[2]; ++k)
          for (int sphere : cells_[index({i, j, k})]) found(sphere);
  }

 private:
  struct Cell {
    long i, j, k;
  };
  Cell cell_of(const Vector3& point) const;  // points outside go to the nearest cell
  std::size_t index(const Cell& c) const { return static_cast<std::size_t>((c.i * n_[1] + c.j) * n_[2] + c.k); }

  Vector3 low_;
  double size_;
  long n_[3];
  std::vector<std::vector<int>> cells_;
};

/// The largest overlap between spheres or with walls, over the (smaller) radius; 0 if nothing touches.
double largest_overlap(const std::vector<Sphere>& spheres, const FreeSpace& space);

struct Relaxation {
  int sweeps = 0;
  double overlap = 0.0;  ///< what is left
};

/// Pushes overlapping spheres apart and off the walls, the lighter one further, until no overlap is larger than
/// `tolerance` or `most_sweeps` are done. Purely geometric (no velocities, no time), the same bits for the same input.
/// In one sweep no centre moves further than a quarter of its radius, so that nothing slips through a thin blade, and
/// none leaves the space. axis: 0, 1, 2 for the axial bounds.
Relaxation relax(std::vector<Sphere>& spheres, const FreeSpace& space, int axis, double tolerance, int most_sweeps);

}  // namespace granary::dem
