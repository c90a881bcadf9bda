// `fix contacthistory` of LIGGGHTS, which its pair style makes for itself: carries what two particles remember of each
// other from one neighbour list to the next.
#pragma once

#include <vector>

#include <fix_contact_history.h>

namespace granary::dem {

/// Told by PairTouching which pairs there are, where LIGGGHTS looks through its lists for them, twice.
class FixTouchHistory : public LAMMPS_NS::FixContactHistory {
 public:
  FixTouchHistory(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg) : FixContactHistory(lammps, narg, arg) {}
  void pre_exchange() override;

 private:
  std::vector<int> n_noted_;  ///< scratch, of each particle
};

}  // namespace granary::dem
