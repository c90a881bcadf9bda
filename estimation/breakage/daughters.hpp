// What fragments break into, averaged over splits.
#pragma once

#include <vector>

#include "estimation/breakage/history.hpp"

namespace granary::estimation {

/// Mean number of daughters with about the share `share` of the parent.
struct MeanDaughter {
  double share = 0.0, number = 0.0;
};

/// Splits that count alike.
struct WeightedSplits {
  const std::vector<Split>* splits = nullptr;
  double weight = 1.0;  ///< > 0
};

/// Of the splits with a parent of `from` to `to` spheres: daughters whose shares lie within a twentieth of ln 2 of each
/// other count together, at their mean share. sum number share = 1 whatever the splits are. Empty if there is none.
std::vector<MeanDaughter> mean_daughters(const std::vector<WeightedSplits>& groups, int from, int to);

}  // namespace granary::estimation
