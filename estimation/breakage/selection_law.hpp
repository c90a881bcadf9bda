// How often fragments are split: a rate from counts with its interval, and a law over size and settings fitted to many.
#pragma once

#include <limits>
#include <vector>

#include "common/result.hpp"

namespace granary::estimation {

/// Events over an exposure [s], with the 95 % interval of a Poisson count (Garwood): exact, also for none.
struct Rate {
  double value = 0.0, low = 0.0, high = 0.0;  ///< [1/s]
};
Rate rate_of(long events, double exposure);

/// Counts that share their features.
struct CountedEvents {
  std::vector<double> features;  ///< shape (n)
  double exposure = 0.0;         ///< [s] > 0
  double events = 0.0;
};

/// ln rate = sum_j coefficient_j feature_j
struct SelectionLaw {
  std::vector<double> coefficient;              ///< shape (n)
  std::vector<std::vector<double>> covariance;  ///< with the dispersion in it, shape (n, n)
  double dispersion = 1.0;  ///< Pearson's chi^2 per degree of freedom, at least 1: how much more the counts scatter
                            ///< than independent events would
  Rate at(const std::vector<double>& features) const;  ///< with its 95 % interval
};

/// The law of greatest likelihood for Poisson counts, by iterated least squares. Errors: without a prior, fewer counts
/// than features; no event at all; features that say the same (a coefficient the counts do not know).
/// @param prior  standard deviation of a normal prior about 0 on every coefficient but the first: where a size never
///               breaks, or a setting was never changed, it keeps the law finite. Infinite: none.
/// Source: P. McCullagh, J. A. Nelder, Generalized Linear Models, 2nd ed., 1989, sections 2.5 and 6.2.
Result<SelectionLaw> fit_selection_law(const std::vector<CountedEvents>& counts,
                                       double prior = std::numeric_limits<double>::infinity());

}  // namespace granary::estimation
