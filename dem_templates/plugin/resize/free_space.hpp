// Where particles may be: what the resize asks about the machine.
#pragma once

#include <vector>

#include "dem_templates/plugin/resize/vector3.hpp"

namespace granary::dem {

/// A wall near a point.
struct NearWall {
  double distance = 0.0;  ///< from the point to the wall [m]
  Vector3 normal{};       ///< unit vector from the wall to the point
};

class FreeSpace {
 public:
  virtual ~FreeSpace() = default;
  /// Whether a point lies in the space at all.
  virtual bool inside(const Vector3& point) const = 0;
  /// Adds the walls nearer than `reach` to `found`.
  virtual void walls_near(const Vector3& point, double reach, std::vector<NearWall>& found) const = 0;
  /// A box around the space.
  virtual Vector3 low() const = 0;
  virtual Vector3 high() const = 0;
};

}  // namespace granary::dem
