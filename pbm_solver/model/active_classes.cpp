#include "pbm_solver/model/active_classes.hpp"

#include <algorithm>
#include <cmath>

#include "common/units.hpp"

namespace granary::pbm {
namespace {

// Of a compartment's solids: what a class must hold to react. Below it there is only the dust of round-off, whose
// products underflow.
constexpr double kNothing = 1e-40;

}  // namespace

ClassPosition position_of(std::span<const double> ln_centre, double diameter) {
  const double x = std::log(diameter);
  const int n = static_cast<int>(ln_centre.size());
  if (n == 1 || !(x > ln_centre.front())) return {0, 0.0};
  if (x >= ln_centre.back()) return {n - 2, 1.0};
  const int upper = static_cast<int>(std::upper_bound(ln_centre.begin(), ln_centre.end(), x) - ln_centre.begin());
  const double low = ln_centre[upper - 1], high = ln_centre[upper];
  return {upper - 1, (x - low) / (high - low)};
}

double external_liquid(double liquid, double gas, double saturation_factor) {
  return std::max(0.0, liquid - std::min(saturation_factor * gas, liquid));
}

double film_thickness(double volume, double external_liquid) {
  static const double per_root = 0.5 * std::cbrt(6.0 / kPi);
  return per_root * (std::cbrt(volume) - std::cbrt(std::max(0.0, volume - external_liquid)));
}

void ActiveClasses::clear() {
  for (auto* list : {&index, &i, &j}) list->clear();
  row_begin.clear();
  for (auto* list : {&number, &liquid, &gas, &solid_1, &solid_2, &solid, &volume, &diameter, &inverse_diameter,
                     &inverse_mass, &film, &liquid_fraction, &porosity})
    list->clear();
  dem.clear();
}

void ActiveClasses::append(const ClassGrid& grid, const Materials& materials, std::size_t k, double total_number,
                           double total_liquid, double total_gas, double participation) {
  const double s1 = grid.solid_1()[k], s2 = grid.solid_2()[k], s = grid.solid()[k];
  const double l = total_liquid / total_number, g = total_gas / total_number;
  const double v = s + l + g;
  const double d = std::cbrt(6.0 / kPi * v);
  const double outside = external_liquid(l, g, materials.saturation_factor);
  number.push_back(total_number * participation);
  liquid.push_back(total_liquid * participation);
  gas.push_back(total_gas * participation);
  solid_1.push_back(s1);
  solid_2.push_back(s2);
  solid.push_back(s);
  volume.push_back(v);
  diameter.push_back(d);
  inverse_diameter.push_back(1.0 / d);
  inverse_mass.push_back(
      1.0 / (materials.solid_density[0] * s1 + materials.solid_density[1] * s2 + materials.liquid_density * l));
  film.push_back(outside > 0.0 ? film_thickness(v, outside) : 0.0);
  liquid_fraction.push_back(outside / v);
  porosity.push_back((l + g) / v);
}

void ActiveClasses::assign(const ClassGrid& grid, const Materials& materials, Fields state,
                           std::span<const double> participation, std::span<const double> ln_dem_diameter) {
  clear();
  double held = 0.0;
  for (std::size_t k = 0; k < grid.size(); ++k) held += grid.solid()[k] * std::max(0.0, state.number[k]);
  for (int row = 0; row < grid.axis(0).size(); ++row) {
    row_begin.push_back(index.size());
    for (int column = 0; column < grid.axis(1).size(); ++column) {
      const std::size_t k = grid.index(row, column);
      if (!(grid.solid()[k] * state.number[k] > kNothing * held)) continue;
      index.push_back(static_cast<int>(k));
      i.push_back(row);
      j.push_back(column);
      append(grid, materials, k, state.number[k], state.liquid[k], state.gas[k],
             participation.empty() ? 1.0 : participation[k]);
      if (!ln_dem_diameter.empty()) dem.push_back(position_of(ln_dem_diameter, diameter.back()));
    }
  }
  row_begin.push_back(index.size());
}

}  // namespace granary::pbm
