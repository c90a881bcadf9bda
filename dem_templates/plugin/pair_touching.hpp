// `pair_style gran` of LIGGGHTS, which looks at all listed pairs in every step: given those that may touch.
#pragma once

#include <vector>

#include <pair_gran_proxy.h>

#include "dem_templates/plugin/lists/near_pairs.hpp"

namespace granary::dem {

/// Forces and what is remembered are worked out by LIGGGHTS, from the particles that have a touching partner, in the
/// order of their numbers: the same to the last bit. All pairs are still looked at where LIGGGHTS does something for
/// those that do not touch: `contact_distance_factor` above 1, multi-contact models, radii that change, predefined
/// insertion.
class PairTouching : public LAMMPS_NS::PairGranProxy {
 public:
  explicit PairTouching(LAMMPS_NS::LAMMPS* lammps) : PairGranProxy(lammps) {}
  void compute_force(int energy, int virials, int add) override;

 private:
  bool only_touching_matter();
  void start();

  NearPairs near_;
  std::vector<ListedPair> listed_;  ///< scratch
  long started_ = -1;               ///< the list, by its number
};

}  // namespace granary::dem
