// The parallel bond between two spheres: forces, moments and when it breaks. Plain numbers: no LIGGGHTS.
#pragma once

#include <algorithm>
#include <cmath>

#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {

enum class BreakMode { tension, shear, bending, torsion };

/// What all bonds are made of.
struct BondMaterial {
  double normal_stiffness = 0.0;  ///< k_n [N/m^3]
  double shear_stiffness = 0.0;   ///< k_s [N/m^3]
  double tensile_strength = 0.0;  ///< [Pa]
  double shear_strength = 0.0;    ///< [Pa]
  double damping = 0.0;           ///< share of the critical damping of each mode [-]
  bool combined = false;          ///< one elliptical test of both stresses instead of two
};

/// One bond and what it remembers. Its state is that of the last step, in the laboratory's frame.
struct Bond {
  double partner = 0.0;   ///< tag of the end with the larger tag; the other end keeps the bond
  double radius = 0.0;    ///< R [m]; 0: it broke
  double length = 0.0;    ///< distance of the centres at which it does not pull [m]
  double strength = 1.0;  ///< of this bond over the material's [-]
  Vector3 normal{};       ///< unit vector to the partner
  Vector3 shear{};        ///< elastic force on this end, across the normal [N]
  Vector3 bend{};         ///< elastic moment on this end, across the normal [N m]
  double twist = 0.0;     ///< elastic moment on this end, along the normal [N m]

  bool broken() const { return radius == 0.0; }
};

/// What follows from radius and masses: set when the bond is looked up, the same in every step.
struct BondSection {
  double normal = 0.0, shear = 0.0;  ///< k_n A, k_s A [N/m]
  double bend = 0.0, twist = 0.0;    ///< k_n I, k_s J [N m]
  double normal_damping = 0.0, shear_damping = 0.0, bend_damping = 0.0, twist_damping = 0.0;
  double per_area = 0.0;     ///< 1/A [1/m^2]
  double bend_stress = 0.0;  ///< R/I; R/J is half of it [1/m^3]
  double share = 0.5;        ///< of the distance that lies between this end and the section [-]
};

struct BondEnd {
  double radius = 0.0, mass = 0.0;
};

/// A = pi R^2, I = pi R^4 / 4, J = 2 I; a dashpot of a mode is 2 damping sqrt(K m*) with m* (or the moment of inertia)
/// of the two ends in series. The section stands where the two spheres would touch.
inline BondSection bond_section(const BondMaterial& material, double radius, const BondEnd& a, const BondEnd& b) {
  const double area = M_PI * radius * radius, second_moment = 0.25 * area * radius * radius;
  BondSection s{.normal = material.normal_stiffness * area,
                .shear = material.shear_stiffness * area,
                .bend = material.normal_stiffness * second_moment,
                .twist = 2.0 * material.shear_stiffness * second_moment,
                .per_area = 1.0 / area,
                .bend_stress = radius / second_moment,
                .share = a.radius / (a.radius + b.radius)};
  const double mass = a.mass * b.mass / (a.mass + b.mass);
  const double inertia_a = 0.4 * a.mass * a.radius * a.radius, inertia_b = 0.4 * b.mass * b.radius * b.radius;
  const double inertia = inertia_a * inertia_b / (inertia_a + inertia_b);
  s.normal_damping = 2.0 * material.damping * std::sqrt(s.normal * mass);
  s.shear_damping = 2.0 * material.damping * std::sqrt(s.shear * mass);
  s.bend_damping = 2.0 * material.damping * std::sqrt(s.bend * inertia);
  s.twist_damping = 2.0 * material.damping * std::sqrt(s.twist * inertia);
  return s;
}

/// How the two ends stand and move: the end that keeps the bond first.
struct BondMotion {
  Vector3 between{};           ///< from this end's centre to the other's [m]
  Vector3 velocity{};          ///< of the other end, less that of this one [m/s]
  Vector3 spin{}, far_spin{};  ///< of this end and the other [rad/s]
};

struct BondLoad {
  Vector3 force{};                 ///< on this end; the other bears the opposite [N]
  Vector3 torque{}, far_torque{};  ///< on this end and the other, about their centres [N m]
  double tension = 0.0;            ///< elastic force along the normal, negative when pressed [N]
};

/// A turn by a small rotation vector, lengths kept: R v = v + 2/(1 + t^2) (t x v + t x (t x v)), t = tan(|a|/2) a/|a|.
class SmallTurn {
 public:
  explicit SmallTurn(const Vector3& angle)
      : t_((0.5 + dot(angle, angle) / 24.0) * angle), scale_(2.0 / (1.0 + dot(t_, t_))) {}
  [[gnu::always_inline]] Vector3 operator()(const Vector3& v) const {
    const Vector3 once = cross(t_, v);
    return v + scale_ * (once + cross(t_, once));
  }

 private:
  Vector3 t_;
  double scale_;
};

/// Advances the bond by a step and gives its load.
///
///   F_n = k_n A (L - L_0)                          total: nothing adds up over the steps
///   F_s <- turn(F_s) + k_s A L (n - n')            n' = R(w dt) n_before: where the section's own spin takes the
///   normal M_b <- turn(M_b) + k_n I (w_j - w_i)_b dt,     M_t += k_s J (w_j - w_i)_n dt
///
/// w is the spin of the section, that of the ends, each with its share; `turn` is R(w dt) and then the shortest turn
/// from n' to n. So a pair that moves as one rigid body feels nothing, however it turns. The moments of the shear force
/// about the centres are such that angular momentum is kept.
/// frozen: the state is used, not advanced (setup). damped: with the dashpots.
/// Source: D. O. Potyondy, P. A. Cundall, Int. J. Rock Mech. Min. Sci. 41 (2004) 1329, eqs. (8)-(16).
[[gnu::always_inline]] inline BondLoad bond_load(const BondSection& s, const BondMotion& m, double time_step,
                                                 bool frozen, bool damped, Bond& bond) {
  const double length = std::sqrt(dot(m.between, m.between));
  const Vector3 n = (1.0 / length) * m.between;
  const Vector3 spin = s.share * m.spin + (1.0 - s.share) * m.far_spin, bending = m.far_spin - m.spin;
  const double twisting = dot(bending, n);

  if (!frozen) {
    const SmallTurn with_section(time_step * spin);
    const Vector3 expected = with_section(bond.normal), both = expected + n;
    const double cosine = dot(expected, n), per_both = 1.0 / (1.0 + cosine);
    const auto turn = [&](const Vector3& v) __attribute__((always_inline)) {
      const Vector3 turned = with_section(v);
      return turned - (dot(turned, n) * per_both) * both;
    };
    bond.shear = turn(bond.shear) + (s.shear * length) * (cosine * n - expected);
    bond.bend = turn(bond.bend) + (s.bend * time_step) * (bending - twisting * n);
    bond.twist += s.twist * time_step * twisting;
    bond.normal = n;
  }

  BondLoad load;
  load.tension = s.normal * (length - bond.length);
  Vector3 across = bond.shear, moment = bond.bend + bond.twist * n;
  double along = load.tension;
  if (damped) {
    const double apart = dot(m.velocity, n);
    along += s.normal_damping * apart;
    across = across + s.shear_damping * (m.velocity - apart * n - length * cross(spin, n));
    moment = moment + s.bend_damping * (bending - twisting * n) + (s.twist_damping * twisting) * n;
  }
  const Vector3 lever = length * cross(n, across);
  load.force = along * n + across;
  load.torque = s.share * lever + moment;
  load.far_torque = (1.0 - s.share) * lever - moment;
  return load;
}

/// Stresses of the bond by its four loads [Pa]: F_n/A, |F_s|/A, |M_b| R/I, |M_t| R/J.
struct BondStress {
  double pull = 0.0, shear = 0.0, bend = 0.0, twist = 0.0;
};
[[gnu::always_inline]] inline BondStress bond_stress(const BondSection& s, double tension, const Bond& bond) {
  return {.pull = tension * s.per_area,
          .shear = std::sqrt(dot(bond.shear, bond.shear)) * s.per_area,
          .bend = std::sqrt(dot(bond.bend, bond.bend)) * s.bend_stress,
          .twist = std::abs(bond.twist) * 0.5 * s.bend_stress};
}

/// The bond breaks when this reaches 1: of sigma = F_n/A + |M_b| R/I and tau = |F_s|/A + |M_t| R/J the larger over its
/// strength, or, combined, (max(sigma, 0)/sigma_c)^2 + (tau/tau_c)^2. Dashpots count nothing, pressure breaks nothing.
[[gnu::always_inline]] inline double bond_overload(const BondMaterial& material, const BondSection& s, double tension,
                                                   const Bond& bond) {
  const BondStress stress = bond_stress(s, tension, bond);
  const double per_strength = 1.0 / bond.strength, sigma = stress.pull + stress.bend;
  const double tears = (sigma > 0.0 ? sigma : 0.0) * per_strength / material.tensile_strength;
  const double slides = (stress.shear + stress.twist) * per_strength / material.shear_strength;
  const double worse = tears > slides ? tears : slides;
  const double ellipse = material.combined ? 1.0 : 0.0;  // no branch: bond_rows.cpp
  return ellipse * (tears * tears + slides * slides) + (1.0 - ellipse) * worse;
}

/// How it broke: the stress that did it [Pa], and the larger share of it (combined: the largest of all four over their
/// strengths).
struct BondBreak {
  BreakMode mode = BreakMode::tension;
  double stress = 0.0;
};
inline BondBreak bond_break(const BondMaterial& material, const BondStress& s) {
  const auto worst = [&](double tensile, double shear) {
    return tensile / material.tensile_strength >= shear / material.shear_strength;
  };
  const bool tears = material.combined ? worst(std::max(s.pull, s.bend), std::max(s.shear, s.twist))
                                       : worst(s.pull + s.bend, s.shear + s.twist);
  if (tears) return {s.pull >= s.bend ? BreakMode::tension : BreakMode::bending, s.pull + s.bend};
  return {s.shear >= s.twist ? BreakMode::shear : BreakMode::torsion, s.shear + s.twist};
}

/// Elastic energy [J].
inline double bond_energy(const BondSection& s, double tension, const Bond& bond) {
  return 0.5 * (tension * tension / s.normal + dot(bond.shear, bond.shear) / s.shear +
                dot(bond.bend, bond.bend) / s.bend + bond.twist * bond.twist / s.twist);
}

}  // namespace granary::dem
