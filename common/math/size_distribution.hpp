// Size distributions as classes with weights: quantiles, moments, distances. Diameters in m.
#pragma once

#include <span>
#include <vector>

namespace granary {

/// Diameter of a sphere of volume v [m^3] -> [m], and back.
double sphere_diameter(double volume);
double sphere_volume(double diameter);

/// Diameter below which the share q (0..1) of the total weight lies. `diameter` [m] need not be sorted; half of each class's weight
/// lies below its diameter, and the cumulative curve is linear in log d between the classes, so that the
/// quantile moves continuously as weight moves between classes. 0 if there is no weight.
/// @param diameter, weight  shape (n_classes); weight >= 0 (volume weights give d50 by volume)
double quantile(std::span<const double> diameter, std::span<const double> weight, double q);

}  // namespace granary
