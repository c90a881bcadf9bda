// Which particles must be looked at in a step, of one body. One that was found clear of the surface by some room can
// touch it only when its centre has moved, in the body's frame, by that room. Nothing depends on it but the speed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "dem_templates/plugin/wall/wall_body.hpp"

namespace granary::dem {

class Watch {
 public:
  void resize(std::size_t n_particles) {
    for (std::vector<float>* of : {&x_, &y_, &z_, &room2_, &clear_}) of->resize(n_particles);
    is_due_.resize(n_particles);
    n_touches_.resize(n_particles);
    nearby_.resize(n_particles);
  }
  void copy(std::size_t from, std::size_t to) {
    for (std::vector<float>* of : {&x_, &y_, &z_, &room2_, &clear_}) (*of)[to] = (*of)[from];
    nearby_[to] = nearby_[from];
    n_touches_[to] = n_touches_[from];
  }
  /// The particle has not been looked at: it is due.
  void forget(std::size_t particle) {
    room2_[particle] = clear_[particle] = 0.0f;
    nearby_[particle].complete = 0.0f;
  }
  /// It will be asked for soon.
  void fetch(std::size_t particle) const { __builtin_prefetch(&nearby_[particle]); }
  Nearby& nearby(std::size_t particle) { return nearby_[particle]; }
  void forget_all() {
    for (std::size_t i = 0; i < nearby_.size(); ++i) forget(i);
  }

  /// Notes a look. here: the centre in the body's frame; clear: the distance that the surface keeps from there at
  /// least [m].
  void looked(std::size_t particle, const Vector3& here, double radius, double clear, std::uint32_t n_touches) {
    constexpr double kRounding = 8.0 * std::numeric_limits<float>::epsilon();
    const double rounding = kRounding * (std::abs(here[0]) + std::abs(here[1]) + std::abs(here[2]) + clear);
    const double room = std::max(0.0, clear - radius - rounding);
    x_[particle] = static_cast<float>(here[0]);
    y_[particle] = static_cast<float>(here[1]);
    z_[particle] = static_cast<float>(here[2]);
    room2_[particle] = static_cast<float>(room * room * (1.0 - 1e-6));
    clear_[particle] = static_cast<float>(clear);
    n_touches_[particle] = static_cast<std::uint8_t>(std::min(n_touches, kKinds - 1));
  }
  /// Whether its centre can have come through the surface since it was last looked at, by leaps of half a radius.
  bool may_have_passed(std::size_t particle, const Vector3& here, double radius) const {
    const double clear = clear_[particle], far = std::max(clear, 0.5 * radius);
    const Vector3 moved = here - last_place(particle);
    return dot(moved, moved) > far * far && clear > 0.0;
  }
  Vector3 last_place(std::size_t particle) const { return {x_[particle], y_[particle], z_[particle]}; }

  /// Numbers of those of the first n particles that are due: first those that did not touch when last looked at, then
  /// those that did once, then the others, for what follows goes the same way for each of a kind. places: x y z of
  /// each, in the laboratory's frame.
  const std::vector<std::uint32_t>& due(const WallBody& body, const double* places, std::size_t n);

 private:
  /// The last looks, in single precision: half as much must be read each step. The room is kept smaller by more than
  /// that can be wrong.
  std::vector<float> x_, y_, z_;  ///< of the centre, in the body's frame
  std::vector<float> room2_;      ///< it may move by the root of this [m^2]; not above 0: due
  std::vector<float> clear_;      ///< distance of the surface then, at least; 0: not looked at yet [m]
  std::vector<Nearby> nearby_;
  std::vector<std::uint8_t> is_due_;
  std::vector<std::uint8_t> n_touches_;  ///< at the last look; kKinds - 1: so many or more
  static constexpr std::uint32_t kKinds = 3;
  std::array<std::vector<std::uint32_t>, kKinds> kind_;
  std::vector<std::uint32_t> due_;
};

}  // namespace granary::dem
