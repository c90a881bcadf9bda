// A body: its surface, how it turns, where it stands now.
#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "dem_templates/plugin/wall/surface.hpp"
#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {

struct WallBody {
  std::string name;
  std::unique_ptr<Surface> surface;
  std::string fingerprint;  ///< of the surface's numbers
  Rotation rotation;

  // angle = start_angle + (step - start_step) angle_per_step: set anew only when rate or time step change, so that
  // a run goes on over a restart with the very same angles.
  double start_angle = 0.0, angle_per_step = 0.0;
  long start_step = -1;  ///< -1: has not stood anywhere yet

  bool turned = false;
  Turn turn;  ///< now

  double angle(long step) const { return start_angle + static_cast<double>(step - start_step) * angle_per_step; }
  /// The rate or the time step may have changed: goes on from where it stands.
  void start(long step, double time_step) {
    const double per_step = rotation.rate * time_step;
    if (start_step >= 0 && per_step == angle_per_step) return;
    start_angle = start_step < 0 ? 0.0 : angle(step);
    start_step = step;
    angle_per_step = per_step;
  }
  void turn_to(long step) {
    turned = start_angle != 0.0 || angle_per_step != 0.0;
    if (turned) turn = Turn::about(rotation.axis, angle(step));
  }

  Vector3 to_body(const Vector3& place) const { return rotation.origin + turn.to_body(place - rotation.origin); }
  Vector3 to_lab(const Vector3& place) const { return rotation.origin + turn.to_lab(place - rotation.origin); }
  /// The same in both frames.
  Vector3 spin() const { return rotation.rate * rotation.axis; }
  /// Of a point of it, in the frame of the point [m/s].
  Vector3 velocity_at(const Vector3& point) const { return cross(spin(), point - rotation.origin); }
  /// Of its fastest point [m/s]; 0 for endless surfaces.
  double tip_speed() const { return std::abs(rotation.rate) * surface->farthest_from(rotation.origin, rotation.axis); }
};

}  // namespace granary::dem
