// Which neighbour skin makes a run cheapest, from one state of it. Pure: no step is run and no clock is read, so the
// same state gives the same skin everywhere, and a trial disturbs nothing.
#pragma once

#include <vector>

#include "dem_templates/plugin/resize/packing.hpp"

namespace granary::dem {

/// One candidate.
struct SkinCost {
  double skin = 0.0;   ///< [m]
  double pairs = 0.0;  ///< that the list holds
  double steps = 0.0;  ///< until the fastest particle has gone half the skin, and the list is made anew
  /// Work of a step, over that of one listed pair:  pairs + (60 particles + 10 pairs) / steps
  double cost(double particles) const;
};

/// Fifteen candidates from a tenth of the largest diameter to one and a half, with the pairs of these particles (of one
/// rank). largest_radius [m] and speed of the fastest [m/s] are of all ranks.
std::vector<SkinCost> try_skins(const std::vector<Sphere>& particles, double largest_radius, double speed,
                                double time_step);

/// The cheapest of them [m].
double best_skin(const std::vector<SkinCost>& tried, double particles);

}  // namespace granary::dem
