// fix ID all granary/balance: moves the cuts between the ranks so that each has as much to do. Syntax:
// docs/dem_styles.md. Where to cut is balance/even_cuts.hpp.
#pragma once

#include <vector>

#include <fix.h>

namespace granary::dem {

class FixBalance : public LAMMPS_NS::Fix {
 public:
  FixBalance(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);

  // What LIGGGHTS calls.
  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void pre_exchange() override;
  /// Load of the busiest rank over the mean of all, when last looked.
  double compute_scalar() override { return imbalance_; }

 private:
  /// Work of each of this rank's particles in a step, in looks at a pair.
  void estimate_work();
  /// Work in equal parts of the box along an axis, of all ranks.
  std::vector<double> load_along(int axis) const;
  /// Moves the cuts across all axes if ranks have unequal work; LIGGGHTS then hands over the particles. Returns whether
  /// it did.
  bool move_cuts();

  long every_ = 20;  ///< neighbour lists between looks
  long lists_ = 0;
  double imbalance_ = 1.0;
  std::vector<double> work_;  ///< scratch
};

}  // namespace granary::dem
