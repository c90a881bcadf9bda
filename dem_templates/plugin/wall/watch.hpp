// Which particles must be looked at in a step, of one body. One that was found clear of the surface by some room can
// touch it only when its centre has moved, in the body's frame, by that room. Nothing depends on it but the speed.
#pragma once

#include <cstdint>
#include <vector>

#include "dem_templates/plugin/wall/wall_body.hpp"

namespace granary::dem {

class Watch {
 public:
  void resize(std::size_t n_particles) {
    for (std::vector<float>* of : {&x_, &y_, &z_, &room2_, &clear_}) of->resize(n_particles);
    is_due_.resize(n_particles);
    nearby_.resize(n_particles);
  }
  void copy(std::size_t from, std::size_t to) {
    for (std::vector<float>* of : {&x_, &y_, &z_, &room2_, &clear_}) (*of)[to] = (*of)[from];
    nearby_[to] = nearby_[from];
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

  /// here: the centre in the body's frame; clear: the distance that the surface keeps from there at least [m].
  void looked(std::size_t particle, const Vector3& here, double radius, double clear);
  /// Whether its centre can have come through the surface since it was last looked at, by leaps of half a radius.
  bool may_have_passed(std::size_t particle, const Vector3& here, double radius) const;
  Vector3 last_place(std::size_t particle) const;

  /// Numbers of those of the first n particles that are due. places: x y z of each, in the laboratory's frame.
  const std::vector<std::uint32_t>& due(const WallBody& body, const double* places, std::size_t n);

 private:
  /// The last looks, in single precision: half as much must be read each step. The room is kept smaller by more than
  /// that can be wrong.
  std::vector<float> x_, y_, z_;  ///< of the centre, in the body's frame
  std::vector<float> room2_;      ///< it may move by the root of this [m^2]; not above 0: due
  std::vector<float> clear_;      ///< distance of the surface then, at least; 0: not looked at yet [m]
  std::vector<Nearby> nearby_;
  std::vector<std::uint8_t> is_due_;
  std::vector<std::uint32_t> due_;
};

}  // namespace granary::dem
