#include "common/math/size_distribution.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/assert.hpp"
#include "common/units.hpp"

namespace granary {

double sphere_diameter(double volume) { return std::cbrt(6.0 * volume / kPi); }
double sphere_volume(double diameter) { return kPi / 6.0 * diameter * diameter * diameter; }

double quantile(std::span<const double> diameter, std::span<const double> weight, double q) {
  GRANARY_ASSERT(diameter.size() == weight.size());
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < diameter.size(); ++i)
    if (weight[i] > 0.0 && diameter[i] > 0.0) order.push_back(i);
  if (order.empty()) return 0.0;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return diameter[a] < diameter[b]; });

  // Cumulative weight up to the middle of each class is reached at its diameter; linear in log d between.
  double total = 0.0;
  for (const std::size_t i : order) total += weight[i];
  const double target = std::clamp(q, 0.0, 1.0) * total;
  double below = 0.0;
  double last_mid = 0.0, last_log = std::log(diameter[order.front()]);
  for (const std::size_t i : order) {
    const double mid = below + 0.5 * weight[i];
    const double log_d = std::log(diameter[i]);
    if (target <= mid) {
      if (mid <= last_mid || below == 0.0) return diameter[i];
      return std::exp(last_log + (log_d - last_log) * (target - last_mid) / (mid - last_mid));
    }
    below += weight[i];
    last_mid = mid;
    last_log = log_d;
  }
  return diameter[order.back()];
}

}  // namespace granary
