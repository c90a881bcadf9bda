#include "dem_templates/plugin/skin/skin_trial.hpp"

#include <algorithm>
#include <cmath>

namespace granary::dem {
namespace {

// Measured on the mixer (docs/dem_styles.md): what making a list costs for a particle and for a pair, over what one
// listed pair costs in a step.
constexpr double kListParticle = 60.0, kListPair = 10.0;
constexpr int kCandidates = 15, kInADiameter = 10;

}  // namespace

double SkinCost::cost(double particles) const {
  return pairs + (kListParticle * particles + kListPair * pairs) / steps;
}

std::vector<SkinCost> try_skins(const std::vector<Sphere>& particles, double largest, double speed, double time_step) {
  std::vector<SkinCost> tried;
  for (int k = 1; k <= kCandidates; ++k) {
    const double skin = 2.0 * largest * k / kInADiameter;
    const double steps = speed > 0.0 ? 0.5 * skin / (speed * time_step) : 1e9;
    tried.push_back({skin, 0.0, std::max(1.0, steps)});
  }
  if (particles.empty()) return tried;

  Vector3 low = particles[0].centre, high = low;
  for (const Sphere& particle : particles)
    for (std::size_t d = 0; d < 3; ++d) {
      low[d] = std::min(low[d], particle.centre[d]);
      high[d] = std::max(high[d], particle.centre[d]);
    }
  const double widest = tried.back().skin;
  SphereGrid grid(low, high, 2.0 * largest + widest);
  for (std::size_t i = 0; i < particles.size(); ++i) grid.add(static_cast<int>(i), particles[i].centre);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    grid.around(particles[i].centre, [&](int j) {
      if (static_cast<std::size_t>(j) <= i) return;
      const Sphere& other = particles[static_cast<std::size_t>(j)];
      const double gap = norm(particles[i].centre - other.centre) - particles[i].radius - other.radius;
      if (gap >= widest) return;
      const double first = std::ceil(gap / widest * kCandidates) - 1.0;  // of the candidates that list it
      tried[static_cast<std::size_t>(std::max(0.0, first))].pairs += 1.0;
    });
  }
  for (std::size_t k = 1; k < tried.size(); ++k) tried[k].pairs += tried[k - 1].pairs;
  return tried;
}

double best_skin(const std::vector<SkinCost>& tried, double particles) {
  const auto cheapest = std::min_element(tried.begin(), tried.end(), [particles](const SkinCost& a, const SkinCost& b) {
    return a.cost(particles) < b.cost(particles);
  });
  return cheapest->skin;
}

}  // namespace granary::dem
