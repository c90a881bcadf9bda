// Planes and cylinders without end.
#pragma once

#include <vector>

#include "dem_templates/plugin/wall/surface.hpp"

namespace granary::dem {

/// Touched on both sides.
class PlaneSurface : public Surface {
 public:
  PlaneSurface(const Vector3& point, const Vector3& unit_normal) : point_(point), normal_(unit_normal) {}
  void look(std::span<Look> looks, std::vector<SurfaceTouch>& found) override;
  bool between(const Vector3& from, const Vector3& to) const override;

 private:
  double height(const Vector3& p) const { return dot(p - point_, normal_); }

  Vector3 point_, normal_;
};

/// Touched from inside and from outside.
class CylinderSurface : public Surface {
 public:
  CylinderSurface(const Vector3& point, const Vector3& unit_axis, double radius)
      : point_(point), axis_(unit_axis), radius_(radius) {}
  void look(std::span<Look> looks, std::vector<SurfaceTouch>& found) override;
  /// From inside to outside or back; not a way that leaves and enters again.
  bool between(const Vector3& from, const Vector3& to) const override;

 private:
  Vector3 off_axis(const Vector3& p) const { return p - point_ - dot(p - point_, axis_) * axis_; }

  Vector3 point_, axis_;
  double radius_;
};

}  // namespace granary::dem
