#include "common/math/size_distribution.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/assert.hpp"
#include "common/units.hpp"

namespace granary {

double sphere_diameter(double volume) { return std::cbrt(6.0 * volume / kPi); }
double sphere_volume(double diameter) { return kPi / 6.0 * diameter * diameter * diameter; }

double log_width_of_pivots(std::span<const double> axis_1, std::span<const double> axis_2) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double least = kNone;
  for (const auto& axis : {axis_1, axis_2})
    for (std::size_t i = 1; i < axis.size(); ++i)
      if (axis[i - 1] > 0.0) least = std::min(least, axis[i] / axis[i - 1]);
  return std::log(least == kNone ? 2.0 : least) / 3.0;
}

double quantile(std::span<const double> diameter, std::span<const double> weight, double q, double log_width) {
  GRANARY_ASSERT(diameter.size() == weight.size() && log_width > 0.0);
  // The density of the weight over ln d is a staircase: up where a class begins, down where it ends.
  struct Edge {
    double at, step;
  };
  std::vector<Edge> edges;
  double total = 0.0;
  for (std::size_t i = 0; i < diameter.size(); ++i) {
    if (!(weight[i] > 0.0) || !(diameter[i] > 0.0)) continue;
    const double middle = std::log(diameter[i]), density = weight[i] / log_width;
    edges.push_back({middle - 0.5 * log_width, density});
    edges.push_back({middle + 0.5 * log_width, -density});
    total += weight[i];
  }
  if (edges.empty()) return 0.0;
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.at < b.at; });

  const double target = std::clamp(q, 0.0, 1.0) * total;
  double below = 0.0, density = 0.0, at = edges.front().at;
  for (const Edge& edge : edges) {
    const double here = density * (edge.at - at);
    if (below + here >= target && here > 0.0) return std::exp(at + (target - below) / density);
    below += here;
    density += edge.step;
    at = edge.at;
  }
  return std::exp(edges.back().at);
}

std::vector<double> shares_below(std::span<const double> diameter, std::span<const double> weight,
                                 std::span<const double> limit, double log_width) {
  GRANARY_ASSERT(diameter.size() == weight.size() && log_width > 0.0);
  std::vector<double> below(limit.size(), 0.0);
  double total = 0.0;
  for (std::size_t i = 0; i < diameter.size(); ++i) {
    if (!(weight[i] > 0.0) || !(diameter[i] > 0.0)) continue;
    const double begins = std::log(diameter[i]) - 0.5 * log_width;
    for (std::size_t k = 0; k < limit.size(); ++k)
      if (limit[k] > 0.0) below[k] += weight[i] * std::clamp((std::log(limit[k]) - begins) / log_width, 0.0, 1.0);
    total += weight[i];
  }
  if (total > 0.0)
    for (double& share : below) share /= total;
  return below;
}

}  // namespace granary
