// The median of a few repeats.
#pragma once

#include <algorithm>
#include <vector>

namespace granary::bench {

/// Of an even number the lower of the middle two; 0 of none.
inline double median(std::vector<double> all) {
  if (all.empty()) return 0.0;
  std::sort(all.begin(), all.end());
  return all[(all.size() - 1) / 2];
}

}  // namespace granary::bench
