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
    looks_.resize(n_particles);
    nearby_.resize(n_particles);
  }
  void copy(std::size_t from, std::size_t to) {
    looks_[to] = looks_[from];
    nearby_[to] = nearby_[from];
  }
  /// The particle has not been looked at: it is due.
  void forget(std::size_t particle) {
    looks_[particle] = {};
    nearby_[particle].complete = 0.0f;
  }
  Nearby& nearby(std::size_t particle) { return nearby_[particle]; }
  void forget_all() {
    for (std::size_t i = 0; i < looks_.size(); ++i) forget(i);
  }

  /// here: the centre in the body's frame; clear: the distance that the surface keeps from there at least [m].
  void looked(std::size_t particle, const Vector3& here, double radius, double clear);
  /// Whether its centre can have come through the surface since it was last looked at, by leaps of half a radius.
  bool may_have_passed(std::size_t particle, const Vector3& here, double radius) const;
  Vector3 last_place(std::size_t particle) const;

  /// Numbers of those of the first n particles that are due. places: x y z of each, in the laboratory's frame.
  const std::vector<std::uint32_t>& due(const WallBody& body, const double* places, std::size_t n);

 private:
  /// Single precision halves what must be read each step; the room is kept smaller by more than that can be wrong.
  struct Look {
    float x = 0.0f, y = 0.0f, z = 0.0f;  ///< of the centre, in the body's frame
    float room2 = 0.0f;                  ///< it may move by the root of this [m^2]; not above 0: due
    float clear = 0.0f;                  ///< distance of the surface then, at least; 0: not looked at yet [m]
  };

  std::vector<Look> looks_;
  std::vector<Nearby> nearby_;
  std::vector<std::uint32_t> due_;
};

}  // namespace granary::dem
