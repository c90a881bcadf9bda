#include "dem_templates/plugin/wall/endless_surfaces.hpp"

#include <cmath>

namespace granary::dem {

void PlaneSurface::look(std::span<Look> looks, std::vector<SurfaceTouch>& found) {
  found.clear();
  for (Look& look : looks) {
    const double h = height(look.centre);
    look.clear = std::abs(h);
    look.first = static_cast<std::uint32_t>(found.size());
    look.n = std::abs(h) < look.radius ? 1 : 0;
    if (look.n > 0) found.push_back({std::abs(h), look.centre - h * normal_, (h < 0.0 ? -1.0 : 1.0) * normal_});
  }
}

bool PlaneSurface::between(const Vector3& from, const Vector3& to) const { return height(from) * height(to) < 0.0; }

void CylinderSurface::look(std::span<Look> looks, std::vector<SurfaceTouch>& found) {
  found.clear();
  for (Look& look : looks) {
    const Vector3 outwards = off_axis(look.centre);
    const double distance = norm(outwards), height = distance - radius_;
    look.clear = std::abs(height);
    look.first = static_cast<std::uint32_t>(found.size());
    look.n = std::abs(height) < look.radius && distance > 0.0 ? 1 : 0;
    if (look.n == 0) continue;
    const Vector3 away = (1.0 / distance) * outwards;
    found.push_back({std::abs(height), look.centre - height * away, (height < 0.0 ? -1.0 : 1.0) * away});
  }
}

bool CylinderSurface::between(const Vector3& from, const Vector3& to) const {
  return (norm(off_axis(from)) - radius_) * (norm(off_axis(to)) - radius_) < 0.0;
}

}  // namespace granary::dem
