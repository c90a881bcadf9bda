// fix ID GROUP granary/skin: its value is the neighbour skin that suits the present state best; it does nothing else.
// Syntax: docs/dem_styles.md.
#pragma once

#include <fix.h>

namespace granary::dem {

class FixSkin : public LAMMPS_NS::Fix {
 public:
  FixSkin(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);

  // What LIGGGHTS calls.
  int setmask() override { return 0; }
  /// [m]. The same on all ranks.
  double compute_scalar() override;
  /// How far lists with that skin reach: the largest diameter and the skin [m].
  double compute_vector(int) override;

 private:
  double least_speed_ = 0.0;  ///< of the fastest particle, also where none is that fast now [m/s]
  long tried_step_ = -1;      ///< of the last trial, and what it gave [m]
  double skin_ = 0.0, largest_diameter_ = 0.0;
};

}  // namespace granary::dem
