// What the data leave open, where the fit is not a parabola: a sample of the parameters' posterior, every point of it
// computed by the model, by adaptive multiple importance sampling [J.-M. Cornuet, J.-M. Marin, A. Mira, C. P. Robert,
// Scandinavian J. Statistics 39 (2012) 798]. Evaluations are independent: as many cores as there are can work at it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "estimation/search/search.hpp"

namespace granary::estimation {

class Posterior {
 public:
  /// Begins with a t distribution of 5 degrees of freedom about the best fit, as wide as its covariance (trust/
  /// uncertainty) says, and becomes as wide as what it finds. `misfit` >= 1: chi^2 per datum; the likelihood is raised
  /// to the power 1 / misfit, as if the errors were larger than stated by its root.
  Posterior(const Point& centre, const std::vector<std::vector<double>>& covariance, std::uint64_t seed,
            double misfit = 1.0);
  Posterior(Posterior&&) noexcept;
  Posterior& operator=(Posterior&&) noexcept;
  ~Posterior();

  /// A point within the unit cube: the prior is uniform there (others are residuals of their own).
  Point ask();
  /// Failed evaluations (nullopt) count as impossible.
  void tell(const Point& at, const std::optional<Residuals>& residuals);

  /// (sum w)^2 / sum w^2 of the sample's weights w = posterior / proposal.
  double effective_samples() const;
  /// The shortest statement of a parameter: quantiles 2.5 % and 97.5 % of the weighted sample, each moved outwards by
  /// the standard error of that share, so that a small sample doesn't pretend to know its tails. Nothing below 10
  /// effective samples.
  struct Interval {
    double low, high;
  };
  std::optional<Interval> interval(std::size_t parameter) const;
  /// Sampled enough for intervals to a tenth of their width: 400 effective samples.
  bool converged() const { return effective_samples() >= 400.0; }
  std::size_t samples() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace granary::estimation
