#include "dem_templates/plugin/wall/watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace granary::dem {

void Watch::looked(std::size_t particle, const Vector3& here, double radius, double clear) {
  const double rounding =
      8.0 * std::numeric_limits<float>::epsilon() * (std::abs(here[0]) + std::abs(here[1]) + std::abs(here[2]) + clear);
  const double room = std::max(0.0, clear - radius - rounding);
  looks_[particle] = {static_cast<float>(here[0]), static_cast<float>(here[1]), static_cast<float>(here[2]),
                      static_cast<float>(room * room * (1.0 - 1e-6)), static_cast<float>(clear)};
}

bool Watch::may_have_passed(std::size_t particle, const Vector3& here, double radius) const {
  const double clear = looks_[particle].clear;
  return clear > 0.0 && norm(here - last_place(particle)) > std::max(clear, 0.5 * radius);
}

Vector3 Watch::last_place(std::size_t particle) const {
  const Look& look = looks_[particle];
  return {look.x, look.y, look.z};
}

const std::vector<std::uint32_t>& Watch::due(const WallBody& body, const double* places, std::size_t n) {
  due_.resize(n);
  const Turn turn = body.turned ? body.turn : Turn{};
  const Vector3 shift = body.to_body({0, 0, 0});
  std::size_t n_due = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = places[3 * i], y = places[3 * i + 1], z = places[3 * i + 2];
    float moved2 = 0.0f;
    const float was[3] = {looks_[i].x, looks_[i].y, looks_[i].z};
    for (std::size_t d = 0; d < 3; ++d) {
      const double here = shift[d] + turn.row[0][d] * x + turn.row[1][d] * y + turn.row[2][d] * z;
      const float moved = static_cast<float>(here) - was[d];
      moved2 += moved * moved;
    }
    due_[n_due] = static_cast<std::uint32_t>(i);
    n_due += !(moved2 < looks_[i].room2);  // no number: due, for the guard's sake not clear of anything
  }
  due_.resize(n_due);
  return due_;
}

}  // namespace granary::dem
