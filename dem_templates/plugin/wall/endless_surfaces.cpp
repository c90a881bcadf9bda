#include "dem_templates/plugin/wall/endless_surfaces.hpp"

#include <cmath>

namespace granary::dem {

double PlaneSurface::touches(const Vector3& centre, double radius, Nearby&, std::vector<SurfaceTouch>& found) {
  found.clear();
  const double h = height(centre);
  if (std::abs(h) < radius) found.push_back({std::abs(h), centre - h * normal_, (h < 0.0 ? -1.0 : 1.0) * normal_});
  return std::abs(h);
}

bool PlaneSurface::between(const Vector3& from, const Vector3& to) const { return height(from) * height(to) < 0.0; }

double CylinderSurface::touches(const Vector3& centre, double radius, Nearby&, std::vector<SurfaceTouch>& found) {
  found.clear();
  const Vector3 outwards = off_axis(centre);
  const double distance = norm(outwards), height = distance - radius_;
  if (std::abs(height) >= radius || distance == 0.0) return std::abs(height);
  const Vector3 away = (1.0 / distance) * outwards;
  found.push_back({std::abs(height), centre - height * away, (height < 0.0 ? -1.0 : 1.0) * away});
  return std::abs(height);
}

bool CylinderSurface::between(const Vector3& from, const Vector3& to) const {
  return (norm(off_axis(from)) - radius_) * (norm(off_axis(to)) - radius_) < 0.0;
}

}  // namespace granary::dem
