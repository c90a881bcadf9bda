// Bars, sparklines and small charts made of characters; with `unicode` of block elements, else of ASCII.
#pragma once

#include <string>
#include <vector>

namespace granary::watch {

/// "[#####...]" so many columns wide in all.
std::string bar(double share, int columns, bool unicode);

/// A curve of unevenly spaced points, brought to `columns` values: the mean of each column's points, else the last one
/// before it. NaN before the first point. `time` rises.
std::vector<double> resampled(const std::vector<double>& time, const std::vector<double>& value, int columns);

/// The area below a curve, in `rows` lines from the top; low..high is the height. NaN leaves a column empty.
std::vector<std::string> area(const std::vector<double>& values, double low, double high, int rows, bool unicode);

}  // namespace granary::watch
