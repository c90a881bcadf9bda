// How well the data know the parameters: covariance, intervals, correlations, and what the data cannot tell apart.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "estimation/search/search.hpp"

namespace granary::estimation {

/// The points to evaluate for central differences about `centre`, two a parameter, `step` away in the unit cube (one of
/// them the centre itself where a bound is nearer than that: a one-sided difference).
std::vector<Point> difference_points(const Point& centre, double step);

/// A combination of parameters along which the fit hardly changes: going `length` along it (unit cube) changes half the
/// sum of squares by 1/2 or less.
struct Unidentified {
  std::vector<double> direction;  ///< unit vector, shape (parameters)
  double length = 0.0;
};

struct Uncertainty {
  std::vector<double> deviation;                 ///< standard deviation of each parameter, unit cube, shape (n)
  std::vector<double> low, high;                 ///< 95 % interval, within the cube, shape (n)
  std::vector<std::vector<double>> correlation;  ///< shape (n, n)
  std::vector<std::vector<double>> covariance;   ///< shape (n, n)
  std::vector<Unidentified> unidentified;
  double chi_square_per_datum = 0.0;  ///< sum of squares over (data - parameters): about 1 for errors as stated
  std::vector<bool> at_bound;         ///< the interval ends at a bound of the parameter
};

/// The mean of n squared residuals of a right model, in units of their errors, stays below this in 95 % of cases: the
/// quantile of chi^2 with n degrees of freedom, over n.
double mean_square_by_chance(std::size_t n);

/// Laplace's approximation at the best fit, covariance (J^T J + 12)^{-1}: the residuals are in units of their errors,
/// and 12 = 1 / variance of a parameter that is only known to lie between its bounds. Where the misfit is larger than
/// the stated errors explain (chi^2 per datum > 1), the covariance is widened by it.
/// @param at         residuals at `centre`
/// @param around     residuals at difference_points(centre, step), in that order; an empty one failed
/// Error: a parameter both of whose differences failed (names its index).
Result<Uncertainty> uncertainty_of(const Point& centre, const Residuals& at, const std::vector<Residuals>& around,
                                   double step);

}  // namespace granary::estimation
