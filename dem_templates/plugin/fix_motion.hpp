// `nve/sphere` and `gravity` of LIGGGHTS with the loops of motion/sphere_motion.hpp: the same numbers, sooner.
#pragma once

#include <fix_gravity.h>
#include <fix_nve_sphere.h>

namespace granary::dem {

/// Of groups other than `all`, dipoles and added mass as LIGGGHTS has it.
class FixNveSphere : public LAMMPS_NS::FixNVESphere {
 public:
  using FixNVESphere::FixNVESphere;
  void initial_integrate(int virials) override;
  void final_integrate() override;

 private:
  bool plain() const;
};

/// Steady gravity on the group `all`; else as LIGGGHTS has it.
class FixGravity : public LAMMPS_NS::FixGravity {
 public:
  using LAMMPS_NS::FixGravity::FixGravity;
  void post_force(int virials) override;
  /// Energy of all particles in it [J].
  double compute_scalar() override;

 private:
  bool plain() const;
};

}  // namespace granary::dem
