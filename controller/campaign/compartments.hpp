// Where the compartments lie in a machine, and how much room each offers.
#pragma once

#include <vector>

#include "dem_templates/case/dem_case.hpp"

namespace granary::campaign {

/// Edges of n equal compartments along the machine's axis [m], shape (n + 1): x of the mixer, z of the bowl.
std::vector<double> compartment_edges(const dem::Machine& machine, int n);

/// Free volume of each compartment [m^3], shape (n): inside the casing, outside the shaft; blades are not counted. The mixer's
/// casing is a cone from inlet to outlet diameter; the bowl a cylinder, a cone to the cover and a spherical cap to the lid.
std::vector<double> compartment_volumes(const dem::Machine& machine, const std::vector<double>& edges);

}  // namespace granary::campaign
