#include "dem_templates/plugin/wall/watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/every_width.hpp"

namespace granary::dem {
namespace {

struct Frame {
  Turn turn;
  Vector3 shift;  ///< of the body's frame: here = shift + turn.to_body(place)
};
struct Looks {
  const float *x, *y, *z, *room2;
};

// Every particle and body comes through here in every step: written so that the compiler can take several particles
// at once, and compiled for the width of each processor. No number counts as moved.
GRANARY_EVERY_WIDTH void find_moved(const Frame& frame, const double* places, std::size_t n, const Looks& looks,
                                    std::uint8_t* moved) {
  const auto [r, shift] = frame;
  const Vector3 r0 = r.row[0], r1 = r.row[1], r2 = r.row[2], s = shift;
  const float *was_x = looks.x, *was_y = looks.y, *was_z = looks.z, *room2 = looks.room2;
  for (std::size_t i = 0; i < n; ++i) {
    const double x = places[3 * i], y = places[3 * i + 1], z = places[3 * i + 2];
    const float dx = static_cast<float>(s[0] + r0[0] * x + r1[0] * y + r2[0] * z) - was_x[i];
    const float dy = static_cast<float>(s[1] + r0[1] * x + r1[1] * y + r2[1] * z) - was_y[i];
    const float dz = static_cast<float>(s[2] + r0[2] * x + r1[2] * y + r2[2] * z) - was_z[i];
    moved[i] = dx * dx + dy * dy + dz * dz < room2[i] ? 0 : 1;
  }
}

}  // namespace

void Watch::looked(std::size_t particle, const Vector3& here, double radius, double clear) {
  const double rounding =
      8.0 * std::numeric_limits<float>::epsilon() * (std::abs(here[0]) + std::abs(here[1]) + std::abs(here[2]) + clear);
  const double room = std::max(0.0, clear - radius - rounding);
  x_[particle] = static_cast<float>(here[0]);
  y_[particle] = static_cast<float>(here[1]);
  z_[particle] = static_cast<float>(here[2]);
  room2_[particle] = static_cast<float>(room * room * (1.0 - 1e-6));
  clear_[particle] = static_cast<float>(clear);
}

bool Watch::may_have_passed(std::size_t particle, const Vector3& here, double radius) const {
  const double clear = clear_[particle], far = std::max(clear, 0.5 * radius);
  const Vector3 moved = here - last_place(particle);
  return clear > 0.0 && dot(moved, moved) > far * far;
}

Vector3 Watch::last_place(std::size_t particle) const { return {x_[particle], y_[particle], z_[particle]}; }

const std::vector<std::uint32_t>& Watch::due(const WallBody& body, const double* places, std::size_t n) {
  find_moved({body.turned ? body.turn : Turn{}, body.to_body({0, 0, 0})}, places, n,
             {x_.data(), y_.data(), z_.data(), room2_.data()}, is_due_.data());
  due_.resize(n);
  std::size_t n_due = 0;
  for (std::size_t i = 0; i < n; ++i) {
    due_[n_due] = static_cast<std::uint32_t>(i);
    n_due += is_due_[i];
  }
  due_.resize(n_due);
  return due_;
}

}  // namespace granary::dem
