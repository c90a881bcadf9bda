// How sure the mean of a series is whose values hang together.
#pragma once

#include <span>

namespace granary::monitor {

/// Standard error of the mean of values that follow each other closely, as those of the same particles do:
///
///   sqrt(s^2 / n (1 + rho) / (1 - rho))      s^2 the variance of the values, rho the correlation of successive ones,
///                                            r + (1 + 3 r) / n of the correlation r that is found, from 0 to 0.95
///
/// A short series shows less correlation than there is; what is missing on average is added. A trend is not known
/// better for its length. Of values that hang together over longer than the whole series it finds too little.
/// Source: bias of r: M. G. Kendall, Biometrika 41 (1954) 403; held against made series in
/// monitor_series_error_test.cpp.
/// @return 0 for fewer than 4 values, which tell nothing.
double error_of_mean(std::span<const double> values);

}  // namespace granary::monitor
