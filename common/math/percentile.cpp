#include "common/math/percentile.hpp"

#include <algorithm>

namespace granary {

double percentile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const double at = q * static_cast<double>(values.size() - 1);
  const auto lower = static_cast<std::size_t>(at);
  const std::size_t upper = std::min(lower + 1, values.size() - 1);
  return values[lower] + (at - static_cast<double>(lower)) * (values[upper] - values[lower]);
}

}  // namespace granary
