// How two spheres, or a sphere and a wall, push each other where they touch: the law of `model hertz tangential
// history [rolling_friction epsd2]` of LIGGGHTS 3.8.0. Plain numbers: no LIGGGHTS.
#pragma once

#include <cmath>

#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {

/// Of two types against each other, as LIGGGHTS' property registry has them.
struct ContactMaterial {
  double young = 0.0;             ///< effective Young's modulus [Pa]
  double shear = 0.0;             ///< effective shear modulus [Pa]
  double damping = 0.0;           ///< ln e / sqrt(ln^2 e + pi^2), not positive [-]
  double friction = 0.0;          ///< Coulomb [-]
  double rolling_friction = 0.0;  ///< [-]
  double cohesion = 0.0;          ///< cohesion energy density; of walls only [J/m^3]
};

/// Two bodies that overlap; the effective radius and mass of one against a wall are its own.
struct ContactState {
  double radius = 0.0;        ///< effective, r_i r_j / (r_i + r_j) [m]
  double mass = 0.0;          ///< effective [kg]
  double overlap = 0.0;       ///< > 0 [m]
  Vector3 normal{};           ///< towards the centre of the one
  double normal_speed = 0.0;  ///< of the one's centre, away from the other [m/s]
  Vector3 slip{};             ///< of its surface over the other's, where they touch [m/s]
};

/// On the one.
struct ContactForce {
  double normal = 0.0;                         ///< spring and dashpot [N]
  Vector3 tangential{};                        ///< [N]
  double spring = 0.0, shear_stiffness = 0.0;  ///< normal, over the overlap, and tangential [N/m]
};

/// Hertz spring and dashpot, Mindlin's tangential spring with history (rotated into the present tangential plane),
/// limited by Coulomb:
///
///   F_n = 4/3 E* sqrt(R d) d - 2 sqrt(5/6) beta sqrt(S_n m) v_n,   S_n = 2 E* sqrt(R d)
///   F_t = min(S_t s - 2 sqrt(5/6) beta sqrt(S_t m) v_t, mu |F_n|), S_t = 8 G* sqrt(R d)   (the dashpot only when
///   sticking)
///
/// shear: tangential displacement, from step to step [m]. frozen: it is used, not advanced (setup).
/// Source: LIGGGHTS manual, pages gran_model_hertz, gran_tangential_history; held against LIGGGHTS itself in
/// plugin_wall_law_test.cpp and plugin_lists_test.cpp.
///
/// Without branches on what differs from touch to touch: several are worked out at once.
template <bool frozen>
[[gnu::always_inline]] inline ContactForce contact_force(const ContactMaterial& material, const ContactState& c,
                                                         double time_step, Vector3& shear) {
  const double kSqrtFiveSixths = 0.91287092917527685576;
  const double root = std::sqrt(c.radius * c.overlap);
  const double normal_stiffness = 2.0 * material.young * root, shear_stiffness = 8.0 * material.shear * root;
  const double spring = 4.0 / 3.0 * material.young * root;
  const double damp = -2.0 * kSqrtFiveSixths * material.damping;
  ContactForce force;
  force.spring = spring;
  force.shear_stiffness = shear_stiffness;
  force.normal = spring * c.overlap - damp * std::sqrt(normal_stiffness * c.mass) * c.normal_speed;

  Vector3 moved = shear;
  if constexpr (!frozen) {
    moved = moved + time_step * c.slip;
    moved = moved - dot(moved, c.normal) * c.normal;
  }
  const double elastic = shear_stiffness * norm(moved), limit = material.friction * std::abs(force.normal);
  const double kept = elastic > limit ? limit / elastic : 1.0;
  const double shear_damping = elastic > limit ? 0.0 : damp * std::sqrt(shear_stiffness * c.mass);
  force.tangential = kept * (-shear_stiffness * moved) - shear_damping * c.slip;
  if constexpr (!frozen) shear = kept * moved;
  return force;
}

/// Resistance to rolling of epsd2, a spring S_t R^2 with history, limited to mu_r |F_n| R:
///
///   M = min(M_before + S_t R^2 w dt, mu_r |F_n| R),  w: what the one turns over the other, but for twisting
///
/// @param turning  of the one against the other [rad/s]
/// @param history  M, from step to step [N m]
/// @return         M; the torque on the one is -M [N m]
/// Source: LIGGGHTS manual, page gran_rolling_friction_epsd2; held against LIGGGHTS itself in the same tests.
template <bool frozen>
[[gnu::always_inline]] inline Vector3 rolling_torque(double rolling_friction, const ContactState& c,
                                                     const ContactForce& force, const Vector3& turning,
                                                     double time_step, Vector3& history) {
  const Vector3 over = turning - dot(turning, c.normal) * c.normal;
  const Vector3 spring = history + (time_step * force.shear_stiffness * c.radius * c.radius) * over;
  const double most = std::abs(force.normal) * c.radius * rolling_friction, size = norm(spring);
  const Vector3 torque = (size > most ? most / size : 1.0) * spring;
  if constexpr (!frozen) history = 1.0 * torque;  // a plain copy of three numbers would make no vector of rows
  return torque;
}

}  // namespace granary::dem
