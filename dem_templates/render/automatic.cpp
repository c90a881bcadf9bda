#include "dem_templates/render/automatic.hpp"

#include <algorithm>
#include <cmath>

#include "common/units.hpp"
#include "dem_templates/geometry/machine.hpp"
#include "dem_templates/render/time_step.hpp"

namespace granary::dem {
namespace {

constexpr double kSoftest = 5e6;            // what LIGGGHTS takes in SI units [Pa]
constexpr double kDiametersPerSlice = 4.0;  // thinner ones are mostly the neighbours' ghosts

double largest_diameter(const DemCase& c) {
  double largest = 0.0;
  for (const Population& p : c.population)
    for (std::size_t i = 0; i < p.diameter.size(); ++i)
      if (p.count[i] > 0) largest = std::max(largest, p.diameter[i]);
  return largest;
}

double length_along(const DemCase& c) { return c.population.back().to - c.population.front().from; }

}  // namespace

double automatic_time_step(const DemCase& c) {
  const double longest = largest_time_step(time_step_figures(c));
  const double digit = std::pow(10.0, std::floor(std::log10(longest)) - 1.0);
  return std::floor(longest / digit * (1.0 + 1e-12)) * digit;
}

int automatic_tally_every(const DemCase& c) {
  constexpr double kMost = 100.0;  // places and speeds are surveyed at the looks, too
  return static_cast<int>(std::clamp(2.0 / 3.0 / time_step_figures(c).contact_share, 1.0, kMost));
}

double automatic_young_modulus(const DemCase& c, double overlap) {
  const TimeStepFigures f = time_step_figures(c);
  const double nu = c.contact.poisson_ratio, r = 0.5 * f.smallest_diameter, v = f.impact_speed;
  const double mass = c.density * kPi / 6.0 * std::pow(f.smallest_diameter, 3);
  const double effective = 15.0 * mass * v * v / (16.0 * std::sqrt(r) * std::pow(overlap * r, 2.5));
  const double compliance = 1.0 / ((1.0 - nu * nu) * effective) - 1.0 / c.contact.wall_young_modulus;
  const double own = c.contact.young_modulus;
  return compliance > 0.0 ? std::min(own, std::max(kSoftest, 1.0 / compliance)) : own;
}

std::array<int, 3> automatic_rank_grid(const DemCase& c) {
  const auto most = std::max(1, static_cast<int>(length_along(c) / (kDiametersPerSlice * largest_diameter(c))));
  const int axis = static_cast<int>(axis_of(c.machine));
  std::array<int, 3> grid{1, 1, 1};
  int slices = std::min(c.ranks, most);
  while (c.ranks % slices != 0) --slices;
  // The bed of a bowl lies on its bottom: it is cut across that.
  if (c.machine.type == Machine::Type::batch_bowl) slices = 1;
  const int rest = c.ranks / slices;
  int wide = static_cast<int>(std::sqrt(static_cast<double>(rest)));
  while (rest % wide != 0) --wide;
  grid[static_cast<std::size_t>(axis)] = slices;
  grid[static_cast<std::size_t>((axis + 1) % 3)] = rest / wide;
  grid[static_cast<std::size_t>((axis + 2) % 3)] = wide;
  return grid;
}

}  // namespace granary::dem
