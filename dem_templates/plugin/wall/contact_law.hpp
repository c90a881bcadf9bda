// The force of a wall on a sphere that touches it: the law of `wall/gran model hertz tangential history
// [rolling_friction cdt|epsd2] [cohesion sjkr]` of LIGGGHTS 3.8.0. Plain numbers: no LIGGGHTS.
#pragma once

#include <algorithm>
#include <cmath>

#include "dem_templates/plugin/contact_force.hpp"
#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {

enum class RollingModel { none, cdt, epsd2 };

struct WallApproach {
  double radius = 0.0, mass = 0.0;
  double overlap = 0.0;  ///< > 0 [m]
  Vector3 normal{};      ///< from the wall to the centre
  Vector3 velocity{};    ///< of the centre, less that of the wall where it is touched [m/s]
  Vector3 spin{};        ///< of the particle [rad/s]
  Vector3 wall_spin{};   ///< of the wall [rad/s]
};

/// What a touch remembers from step to step.
struct TouchHistory {
  Vector3 shear{};           ///< tangential displacement [m]
  Vector3 rolling_torque{};  ///< of the spring of epsd2 [N m]
};

struct WallForce {
  Vector3 force{}, torque{};  ///< on the particle, about its centre [N], [N m]
  double normal_force = 0.0;  ///< spring and dashpot [N]
  double normal_speed = 0.0;  ///< of the approach, away from the wall [m/s]
  double slip2 = 0.0;         ///< square of the speed of the particle's surface over the wall's [m^2/s^2]
};

/// contact_force(), with rolling resistance and cohesion:
///
///   cdt: M = mu_r k_n d R;  epsd2: spring S_t R^2, limited to mu_r |F_n| R;  sjkr: -k_c pi (R^2 - (R - d)^2)
///
/// One thing differs from wall/gran: rolling resistance goes by the spin relative to the wall's (as between two
/// particles), where wall/gran takes the particle's own. frozen: the history is used, not advanced (setup).
/// Source: LIGGGHTS manual, pages gran_model_hertz, gran_tangential_history, gran_rolling_friction_*,
/// gran_cohesion_sjkr; held against LIGGGHTS itself in plugin_wall_law_test.cpp.
///
/// Without branches on what differs from touch to touch: wall_rows.cpp works on several at once.
template <RollingModel rolling, bool frozen>
[[gnu::always_inline]] inline WallForce wall_force(const ContactMaterial& material, const WallApproach& a,
                                                   double time_step, TouchHistory& history) {
  const double distance = a.radius - a.overlap;
  const double normal_speed = dot(a.velocity, a.normal);
  const double arm = a.radius - 0.5 * a.overlap;  // to where it touches: halfway into the overlap
  const Vector3 slip = a.velocity - normal_speed * a.normal + arm * cross(a.normal, a.spin);
  const ContactState state{a.radius, a.mass, a.overlap, a.normal, normal_speed, slip};
  const ContactForce contact = contact_force<frozen>(
      {material.young, material.shear, material.damping, material.friction}, state, time_step, history.shear);
  const double normal_force = contact.normal;
  const Vector3 tangential = contact.tangential;

  const double cohesion = material.cohesion * M_PI * (a.radius * a.radius - distance * distance);
  WallForce result;
  result.normal_force = normal_force;
  result.normal_speed = normal_speed;
  result.slip2 = dot(slip, slip);
  result.force = (normal_force - cohesion) * a.normal + tangential;
  result.torque = -arm * cross(a.normal, tangential);
  const Vector3 turning = (arm / distance) * (a.spin - a.wall_spin);
  if constexpr (rolling == RollingModel::cdt) {
    const double rate = norm(turning), most = material.rolling_friction * contact.spring * a.overlap * a.radius;
    const Vector3 resisting = (rate > 0.0 ? most / rate : 0.0) * turning;
    result.torque = result.torque - (resisting - dot(resisting, a.normal) * a.normal);
  } else if constexpr (rolling == RollingModel::epsd2) {
    result.torque = result.torque - rolling_torque<frozen>(material.rolling_friction, state, contact, turning,
                                                           time_step, history.rolling_torque);
  }
  return result;
}

}  // namespace granary::dem
