#include "dem_templates/render/feed.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/units.hpp"

namespace granary::dem {

double feed_diameter(const DemCase& c) {
  if (c.feed_diameter > 0.0) return c.feed_diameter;
  for (const Population& p : c.population) {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < p.diameter.size(); ++i)
      if (p.count[i] > 0) smallest = std::min(smallest, p.diameter[i]);
    if (std::isfinite(smallest)) return smallest;
  }
  return 0.0;
}

long feed_every(const DemCase& c) {
  const double particle = c.density * kPi / 6.0 * std::pow(feed_diameter(c), 3);
  const double seconds = std::clamp(particle / c.feed_rate, 1e-3, 0.1);
  return std::max(1L, std::lround(seconds / c.time_step));
}

}  // namespace granary::dem
