#include "dem_templates/plugin/balance/even_cuts.hpp"

#include <algorithm>

namespace granary::dem {
namespace {

/// cumulated[k]: of the first k parts.
std::vector<double> cumulate(std::span<const double> load) {
  std::vector<double> cumulated{0.0};
  for (const double part : load) cumulated.push_back(cumulated.back() + part);
  return cumulated;
}

/// Of what lies below a place in [0, 1].
double below(const std::vector<double>& cumulated, double place) {
  const double parts = static_cast<double>(cumulated.size() - 1), at = std::clamp(place * parts, 0.0, parts);
  const auto k = std::min(cumulated.size() - 2, static_cast<std::size_t>(at));
  return cumulated[k] + (at - static_cast<double>(k)) * (cumulated[k + 1] - cumulated[k]);
}

/// Where that much lies below.
double place_of(const std::vector<double>& cumulated, double load) {
  const auto after = std::upper_bound(cumulated.begin() + 1, cumulated.end() - 1, load);
  const auto k = static_cast<std::size_t>(after - cumulated.begin()) - 1;
  const double part = cumulated[k + 1] - cumulated[k], into = part > 0.0 ? (load - cumulated[k]) / part : 0.0;
  return (static_cast<double>(k) + std::clamp(into, 0.0, 1.0)) / static_cast<double>(cumulated.size() - 1);
}

}  // namespace

std::vector<double> even_cuts(std::span<const double> load, const std::vector<double>& now, double least) {
  const std::vector<double> cumulated = cumulate(load);
  if (cumulated.back() <= 0.0) return now;
  const auto n_slices = static_cast<double>(now.size() - 1);
  std::vector<double> cuts = now;
  for (std::size_t k = 1; k + 1 < now.size(); ++k) {
    const double wanted = place_of(cumulated, static_cast<double>(k) / n_slices * cumulated.back());
    const double low = std::max(now[k - 1], cuts[k - 1]) + least, high = now[k + 1] - least;
    cuts[k] = high > low ? std::clamp(wanted, low, high) : now[k];
  }
  return cuts;
}

double imbalance(std::span<const double> load, const std::vector<double>& cuts) {
  const std::vector<double> cumulated = cumulate(load);
  if (cumulated.back() <= 0.0) return 1.0;
  double most = 0.0;
  for (std::size_t k = 1; k < cuts.size(); ++k)
    most = std::max(most, below(cumulated, cuts[k]) - below(cumulated, cuts[k - 1]));
  return most * static_cast<double>(cuts.size() - 1) / cumulated.back();
}

}  // namespace granary::dem
