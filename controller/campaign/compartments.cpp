#include "controller/campaign/compartments.hpp"

#include <algorithm>
#include <cmath>

#include "common/units.hpp"

namespace granary::campaign {
namespace {

/// Volume of a cone cut at two diameters [m^3].
double cone_volume(double diameter, double other_diameter, double height) {
  return kPi / 12.0 * height * (diameter * diameter + diameter * other_diameter + other_diameter * other_diameter);
}

double mixer_volume(const dem::HorizontalMixer& mixer, double from, double to) {
  const auto casing = [&](double x) {
    return mixer.inlet_diameter + (mixer.outlet_diameter - mixer.inlet_diameter) * x / mixer.length;
  };
  const double shaft = std::max(0.0, std::min(to, mixer.shaft_length) - from);
  return cone_volume(casing(from), casing(to), to - from) - cone_volume(mixer.shaft_diameter, mixer.shaft_diameter, shaft);
}

double bowl_volume(const dem::BatchBowl& bowl) {
  const double cap = bowl.lid_height - bowl.cover_height;
  const double cap_radius = bowl.cover_diameter / 2.0;
  return cone_volume(bowl.bottom_diameter, bowl.bottom_diameter, bowl.cylinder_height) +
         cone_volume(bowl.bottom_diameter, bowl.cover_diameter, bowl.cover_height - bowl.cylinder_height) +
         kPi / 6.0 * cap * (3.0 * cap_radius * cap_radius + cap * cap);
}

}  // namespace

std::vector<double> compartment_edges(const dem::Machine& machine, int n) {
  const double length = machine.type == dem::Machine::Type::cm5 ? machine.mixer.length : machine.bowl.lid_height;
  std::vector<double> edges;
  for (int i = 0; i <= n; ++i) edges.push_back(length * i / n);
  return edges;
}

std::vector<double> compartment_volumes(const dem::Machine& machine, const std::vector<double>& edges) {
  if (machine.type == dem::Machine::Type::batch_bowl) {
    // The bowl is one well-mixed compartment (checks.cpp); more are shared out evenly.
    const std::size_t n = edges.size() - 1;
    return std::vector<double>(n, bowl_volume(machine.bowl) / static_cast<double>(n));
  }
  std::vector<double> volumes;
  for (std::size_t i = 1; i < edges.size(); ++i) volumes.push_back(mixer_volume(machine.mixer, edges[i - 1], edges[i]));
  return volumes;
}

}  // namespace granary::campaign
