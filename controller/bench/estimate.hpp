// Means of fluctuating measurements with their statistical errors, and whether two of them differ.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/json/value.hpp"

namespace granary::bench {

/// One quantity as independent runs measured it: `run[s][b]` is its mean over batch b of the run with seed s.
struct Measured {
  std::string name, unit;
  std::vector<std::vector<double>> run;
};

/// Mean and its standard error.
///
///   batches   e^2 = sum_s,b (x_sb - x_b)^2 / (n_b (n_s - 1)) / (n_s n_b)     x_b: mean over the runs, where there are
///             several; the mean of the run where there is one
///   runs      e^2 = sum_s (x_s - x)^2 / (n_s - 1) / n_s                      three runs and more
///
/// The larger of both: what drifts alike in all runs is no noise, what lasts longer than a batch is.
struct Estimate {
  double mean = 0.0, error = 0.0;
  std::size_t runs = 0, batches = 0;  ///< batches of all runs together
  double relative_error() const { return mean != 0.0 ? error / mean : 0.0; }
};
Estimate estimate(const Measured& measured);

/// The same quantity measured in two ways.
struct Difference {
  std::string name, unit;
  Estimate a, b;
  double relative() const { return a.mean != 0.0 ? b.mean / a.mean - 1.0 : 0.0; }  ///< b over a, less one
  double relative_error() const;                                                   ///< of relative()
  double z() const;  ///< difference over its statistical error
};
/// Quantities of the same name, in a's order.
std::vector<Difference> differences(const std::vector<Measured>& a, const std::vector<Measured>& b);

/// The |z| that chance alone exceeds once in 1/p among `n` quantities whose errors have `freedom` degrees of freedom:
/// Student's t, two-sided, each quantity at p / n.
double largest_z(std::size_t n, std::size_t freedom, double p);

json::Value to_json(const Estimate& estimate);
json::Value to_json(const std::vector<Difference>& all);

}  // namespace granary::bench
