// What is fed while the machine runs.
#pragma once

#include "dem_templates/case/dem_case.hpp"

namespace granary::dem {

/// Diameter of the fed particles: as asked, or the smallest of the first compartment that holds any. [m]
double feed_diameter(const DemCase& dem_case);

/// Steps between two insertions, so that about one particle comes at a time.
long feed_every(const DemCase& dem_case);

}  // namespace granary::dem
