#include "pbm_solver/bench/cost_front.hpp"

#include <algorithm>
#include <cmath>

#include "common/assert.hpp"

namespace granary::pbm::bench {

CostAtError cost_at_error(std::vector<CostPoint> points, double error) {
  GRANARY_ASSERT(!points.empty(), points.size());
  std::sort(points.begin(), points.end(), [](const CostPoint& a, const CostPoint& b) {
    return a.cost < b.cost || (a.cost == b.cost && a.error < b.error);
  });
  std::vector<CostPoint> front;  // costs rise, errors fall
  for (const CostPoint& p : points)
    if (front.empty() || p.error < front.back().error) front.push_back(p);
  if (error >= front.front().error) return {front.front().cost, true};
  for (std::size_t k = 1; k < front.size(); ++k) {
    const CostPoint &above = front[k - 1], &below = front[k];
    if (error < below.error) continue;
    const double share = std::log(above.error / error) / std::log(above.error / below.error);
    return {above.cost * std::pow(below.cost / above.cost, share), true};
  }
  return {front.back().cost, false};
}

}  // namespace granary::pbm::bench
