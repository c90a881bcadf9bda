#include "controller/campaign/powder.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace granary::campaign {
namespace {

constexpr double kSmallestFed = 5e-16;  // of each solid [m^3]
constexpr double kFedRatio = 3.0;
constexpr std::array<double, 9> kFedRate{726657587, 286654401, 118218011, 50319795, 20954036,
                                         7345998,   1500147,   76518,     149};

struct Share {
  int i;
  double weight;
};

/// The pivots around volume v and their weights: sum of weights 1, mean of pivots v. Empty outside the grid.
std::vector<Share> shares(const pbm::Grid& grid, int k, double v) {
  constexpr double kRoundOff = 1e-9;
  for (int i = 0; i < grid.bins[k]; ++i)
    if (std::abs(v / pivot(grid, k, i) - 1.0) < kRoundOff) return {{i, 1.0}};
  for (int i = 0; i + 1 < grid.bins[k]; ++i) {
    const double low = pivot(grid, k, i), high = pivot(grid, k, i + 1);
    if (low < v && v < high) return {{i, (high - v) / (high - low)}, {i + 1, (v - low) / (high - low)}};
  }
  return {};
}

}  // namespace

double pivot(const pbm::Grid& grid, int k, int i) {
  const auto component = static_cast<std::size_t>(k);
  return grid.smallest[component] * std::pow(grid.ratio[component], i);
}

double solid_mass(const std::vector<pbm::ClassRate>& classes, const pbm::Grid& grid, const pbm::Materials& materials) {
  double mass = 0.0;
  for (const pbm::ClassRate& fed : classes)
    mass += fed.rate *
            (pivot(grid, 0, fed.i) * materials.solid_density[0] + pivot(grid, 1, fed.j) * materials.solid_density[1]);
  return mass;
}

Result<std::vector<pbm::ClassRate>> published_feed(const pbm::Grid& grid) {
  std::map<std::pair<int, int>, double> rates;
  double solid = kSmallestFed;
  for (const double rate : kFedRate) {
    const auto first = shares(grid, 0, solid), second = shares(grid, 1, solid);
    if (first.empty() || second.empty()) {
      return Error{fmt::format(
          "the published feed has particles with {:.3g} m^3 of each solid, which is outside the grid of /pbm.", solid)};
    }
    for (const Share& a : first)
      for (const Share& b : second) rates[{a.i, b.i}] += rate * a.weight * b.weight;
    solid *= kFedRatio;
  }
  std::vector<pbm::ClassRate> classes;
  for (const auto& [cell, rate] : rates) classes.push_back({cell.first, cell.second, rate});
  return classes;
}

}  // namespace granary::campaign
