#include "controller/monitor/series_error.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace granary::monitor {

namespace {
constexpr std::size_t kLeastValues = 4;
constexpr double kMostCorrelation = 0.95;
}  // namespace

double error_of_mean(std::span<const double> values) {
  if (values.size() < kLeastValues) return 0.0;
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double scatter = 0.0, correlation = 0.0, last = 0.0;
  for (const double value : values) {
    const double deviation = value - mean;
    scatter += deviation * deviation;
    correlation += deviation * last;
    last = deviation;
  }
  if (!(scatter > 0.0)) return 0.0;
  const double found = correlation / scatter;
  const double rho = std::clamp(found + (1.0 + 3.0 * std::max(found, 0.0)) / n, 0.0, kMostCorrelation);
  return std::sqrt(scatter / (n * (n - 1.0)) * (1.0 + rho) / (1.0 - rho));
}

}  // namespace granary::monitor
