// The statistics of a few repeats.
#pragma once

#include <utility>
#include <vector>

namespace granary {

/// The value below which the share q (0..1) of the values lies, between neighbours by straight line; 0 of none.
double percentile(std::vector<double> values, double q);
inline double median(std::vector<double> values) { return percentile(std::move(values), 0.5); }

}  // namespace granary
