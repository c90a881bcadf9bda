// The differences about a best fit, some of which come late or never: which to ask for, and what they say.
#pragma once

#include <optional>
#include <vector>

#include "estimation/trust/uncertainty.hpp"

namespace granary::estimation {

class Differences {
 public:
  Differences(Point centre, Residuals at, double cost);

  const Point& centre() const { return centre_; }
  double cost() const { return cost_; }  ///< at the centre
  const Point& point(std::size_t k) const { return points_[k]; }
  /// Whether this is a difference of this centre: those of an earlier one may still arrive.
  bool is(long k, const Point& at) const;

  /// One that is missing and is not known to fail, whose turn it is: each is asked for in turn, then none for a while
  /// (what was asked for may be on its way), then again.
  std::optional<std::size_t> next();
  /// The first result counts; a point fails when it has failed twice.
  void tell(long k, const std::optional<Residuals>& residuals);
  bool complete() const;
  /// Once complete. Where a parameter's differences all failed, nothing is known of it: the width of the cube.
  Uncertainty uncertainty() const;

 private:
  bool settled(std::size_t k) const { return !around_[k].empty() || failures_[k] >= 2; }

  Point centre_;
  Residuals at_;
  double cost_;
  std::vector<Point> points_;
  std::vector<Residuals> around_;  ///< empty: missing
  std::vector<int> failures_;
  std::size_t turn_ = 0;
};

}  // namespace granary::estimation
