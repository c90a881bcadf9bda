#include "dem_templates/plugin/wall/watch.hpp"

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
  std::array<std::uint32_t*, kKinds> end{};
  for (std::size_t k = 0; k < kKinds; ++k) {
    if (kind_[k].size() < n) kind_[k].resize(n);
    end[k] = kind_[k].data();
  }
  for (const std::uint32_t i : due_) *end[n_touches_[i]]++ = i;
  std::uint32_t* to = due_.data();
  for (std::size_t k = 0; k < kKinds; ++k) to = std::copy(kind_[k].data(), end[k], to);
  return due_;
}

}  // namespace granary::dem
