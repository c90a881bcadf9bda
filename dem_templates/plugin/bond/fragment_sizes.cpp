#include "dem_templates/plugin/bond/fragment_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granary::dem {
namespace {

using Particles = std::unordered_map<Tag, FragmentParticle>;

// Of all of them, as if the box did not repeat.
std::vector<FragmentParticle> unfolded(const std::vector<Tag>& fragment, const BondGraph& graph,
                                       const Particles& particles, const Vector3& period) {
  std::unordered_map<Tag, Vector3> places{{fragment[0], particles.at(fragment[0]).centre}};
  std::vector<Tag> reached{fragment[0]};
  for (std::size_t at = 0; at < reached.size(); ++at) {
    const Vector3 here = places.at(reached[at]);
    for (const Tag other : graph.bonded_to(reached[at])) {
      if (places.contains(other)) continue;
      Vector3 there = particles.at(other).centre;
      for (std::size_t d = 0; d < 3; ++d)
        if (period[d] > 0.0) there[d] -= period[d] * std::round((there[d] - here[d]) / period[d]);
      places[other] = there;
      reached.push_back(other);
    }
  }
  std::vector<FragmentParticle> all;
  for (const Tag tag : fragment) all.push_back({places.at(tag), particles.at(tag).radius});
  return all;
}

}  // namespace

FragmentSize fragment_size(const std::vector<Tag>& fragment, const BondGraph& graph, const Particles& particles,
                           const Vector3& period) {
  const std::vector<FragmentParticle> all = unfolded(fragment, graph, particles, period);
  double cubes = 0.0, own = 0.0;
  Vector3 centre{};
  for (const auto& [x, r] : all) {
    const double cube = r * r * r;
    cubes += cube;
    own += 0.6 * cube * r * r;
    centre = centre + cube * x;
  }
  centre = (1.0 / cubes) * centre;
  double second = own;
  for (const auto& [x, r] : all) second += r * r * r * dot(x - centre, x - centre);
  return {.volume = 4.0 / 3.0 * std::numbers::pi * cubes,
          .diameter = 2.0 * std::cbrt(cubes),
          .spread_diameter = 2.0 * std::sqrt(5.0 / 3.0 * second / cubes)};
}

double weighted_quantile(std::vector<std::pair<double, double>> list, double fraction) {
  if (list.empty()) return 0.0;
  std::sort(list.begin(), list.end());
  double sum = 0.0, below = 0.0;
  for (const auto& [size, weight] : list) sum += weight;
  for (const auto& [size, weight] : list) {
    below += weight;
    if (below >= fraction * sum * (1.0 - 1e-12)) return size;
  }
  return list.back().first;
}

}  // namespace granary::dem
