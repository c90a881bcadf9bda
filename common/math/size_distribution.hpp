// Size distributions as classes with weights: quantiles, moments, distances. Diameters in m.
#pragma once

#include <span>
#include <vector>

namespace granary {

/// Diameter of a sphere of volume v [m^3] -> [m], and back.
double sphere_diameter(double volume);
double sphere_volume(double diameter);

/// Diameter below which the share q (0..1) of the total weight lies. Each class's weight lies evenly over ln d within
/// `log_width` around its diameter (the spacing of the grid it comes from), so that the quantile moves continuously as
/// weights or diameters do: classes of a 2-D grid crowd around the same diameters, and a curve through their centres
/// would have steps. 0 if there is no weight.
/// @param diameter, weight  shape (n_classes), in any order; weight >= 0 (volume weights give d50 by volume)
/// @param log_width         > 0 [-]
double quantile(std::span<const double> diameter, std::span<const double> weight, double q, double log_width);

/// The share of the weight below each limit (0..1), of the same curve: quantile()'s inverse. All 0 if there is no
/// weight.
/// @param limit  diameters [m], shape (n)
std::vector<double> shares_below(std::span<const double> diameter, std::span<const double> weight,
                                 std::span<const double> limit, double log_width);

/// Spacing in ln d of a grid with these pivots on its axes [m^3]: a third of the smallest ln of the ratio of
/// neighbours; pivots at 0 (a solid that is absent) don't count; ln(2) / 3 if no axis has two.
double log_width_of_pivots(std::span<const double> axis_1, std::span<const double> axis_2);

}  // namespace granary
