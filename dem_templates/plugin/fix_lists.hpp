// fix ID all granary/lists: says when the neighbour lists are made anew, in the place of LIGGGHTS' own check. Why it
// may do so less often is in lists/turning_frame.hpp. Syntax: docs/dem_styles.md.
#pragma once

#include <fix.h>

#include "dem_templates/plugin/lists/turning_frame.hpp"

namespace granary::dem {

class FixLists : public LAMMPS_NS::Fix {
 public:
  FixLists(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixLists() override;

  // What LIGGGHTS calls.
  int setmask() override;
  void init() override;
  void setup_pre_force(int) override { start(); }
  void pre_force(int) override;
  /// Particles have just moved; after this LIGGGHTS decides.
  void post_integrate() override;
  /// Rate at which the frame turns [rad/s].
  double compute_scalar() override { return rate_; }

 private:
  /// The lists have been made: whence the particles move, and in which frame they do so slowest.
  void start();
  bool may_turn() const;

  int axis_ = 0;
  TurningFrame frame_{0};
  double rate_ = 0.0;   ///< of the frame [rad/s]
  double angle_ = 0.0;  ///< it has turned by since the lists were made [rad]
  int delay_ = 0;       ///< of LIGGGHTS' own check [steps]
};

}  // namespace granary::dem
