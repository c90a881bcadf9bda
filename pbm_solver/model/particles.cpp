#include "pbm_solver/model/particles.hpp"

#include <math.h>  // not <cmath>: the vector forms belong to the global names

#include <algorithm>
#include <array>

#include "common/every_width.hpp"
#include "common/units.hpp"

namespace granary::pbm {
namespace {

constexpr double kHolds = 1e-8;  // of a compartment's solids: what a class must hold for its changes to count

struct Columns {
  const double *solid, *solid_mass, *liquid, *gas;
  double *diameter, *inverse_diameter, *inverse_mass, *film, *liquid_fraction, *porosity, *volume;
};

GRANARY_EVERY_WIDTH
void fill(const Columns& c, std::size_t n, double saturation_factor, double liquid_density, double film_factor) {
  const double per_volume = 6.0 / kPi;
#pragma omp simd
  for (std::size_t k = 0; k < n; ++k) {
    const double l = c.liquid[k], g = c.gas[k], v = c.solid[k] + l + g;
    const double inside = saturation_factor * g < l ? saturation_factor * g : l;
    const double outside = l - inside;
    const double root = cbrt(v), core = cbrt(v - outside);
    const double d = cbrt(per_volume) * root;
    c.volume[k] = v;
    c.diameter[k] = d;
    c.inverse_diameter[k] = 1.0 / d;
    c.inverse_mass[k] = 1.0 / (c.solid_mass[k] + liquid_density * l);
    c.film[k] = outside > 0.0 ? film_factor * (root - core) : 0.0;
    c.liquid_fraction[k] = outside / v;
    c.porosity[k] = (l + g) / v;
  }
}

struct Change {
  const double *number, *liquid, *gas, *solid, *known_volume, *known_liquid, *dry_area;
  double saturation_factor, tolerance, asperity;
};

/// How much further than allowed the class has moved, negative: not so far. Totals are compared with what they would be
/// if no particle had changed: no division by the number.
inline __attribute__((always_inline)) double excess(const Change& c, std::size_t k, double least) {
  const double number = c.number[k], liquid = c.liquid[k], gas = c.gas[k];
  const double soaked = c.saturation_factor * gas, inside = soaked < liquid ? soaked : liquid;
  const double volume_change = fabs(c.solid[k] * number + liquid + gas - number * c.known_volume[k]);
  const double film_change = fabs(liquid - inside - number * c.known_liquid[k]);
  const double of_volume = volume_change - c.tolerance * number * c.known_volume[k];
  const double of_film = film_change - c.tolerance * number * (c.known_liquid[k] + c.asperity * c.dry_area[k]);
  const double further = of_volume > of_film ? of_volume : of_film;
  return c.solid[k] * number > least ? further : -1.0;
}

GRANARY_EVERY_WIDTH
bool any_moved(const Change& c, std::size_t n, std::size_t lanes) {
  double least[kLanes] = {}, furthest[kLanes];
  for (std::size_t l = 0; l < kLanes; ++l) furthest[l] = -1.0;
  if (lanes == 1) {
#pragma omp simd reduction(+ : least[0])
    for (std::size_t k = 0; k < n; ++k) least[0] += kHolds * c.solid[k] * c.number[k];
#pragma omp simd reduction(max : furthest[0])
    for (std::size_t k = 0; k < n; ++k) furthest[0] = fmax(furthest[0], excess(c, k, least[0]));
    return furthest[0] > 0.0;
  }
  for (std::size_t k = 0; k < n; k += kLanes)
#pragma omp simd
    for (std::size_t l = 0; l < kLanes; ++l) least[l] += kHolds * c.solid[k + l] * c.number[k + l];
  for (std::size_t k = 0; k < n; k += kLanes)
#pragma omp simd
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double e = excess(c, k + l, least[l]);
      furthest[l] = e > furthest[l] ? e : furthest[l];
    }
  bool moved = false;
  for (const double f : furthest) moved |= f > 0.0;
  return moved;
}

}  // namespace

ClassPosition position_of(std::span<const double> ln_centre, double x) {
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

SolidLanes::SolidLanes(const ClassGrid& grid, const Materials& materials, int lanes) {
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const double s = grid.solid()[k], d = std::cbrt(6.0 / kPi * s);
    const auto times = static_cast<std::size_t>(lanes);
    solid.insert(solid.end(), times, s);
    mass.insert(mass.end(), times,
                materials.solid_density[0] * grid.solid_1()[k] + materials.solid_density[1] * grid.solid_2()[k]);
    dry_area.insert(dry_area.end(), times, kPi * d * d);
  }
}

ParticleTable::ParticleTable(const SolidLanes& solids, const Materials& materials)
    : solids_(&solids), saturation_factor_(materials.saturation_factor), liquid_density_(materials.liquid_density) {
  for (auto* list : {&diameter, &inverse_diameter, &inverse_mass, &film, &liquid_fraction, &porosity, &volume, &liquid_,
                     &gas_, &known_liquid_})
    list->resize(solids.solid.size());
}

void ParticleTable::look_at(const double* number, const double* liquid, const double* gas) {
  for (std::size_t k = 0; k < liquid_.size(); ++k) {
    const bool there = number[k] > 0.0;
    const double per_number = there ? 1.0 / number[k] : 0.0;
    liquid_[k] = std::max(0.0, liquid[k] * per_number);
    gas_[k] = std::max(0.0, gas[k] * per_number);
  }
}

bool ParticleTable::moved(const double* number, const double* liquid, const double* gas, double tolerance,
                          double asperity, int lanes) const {
  if (!known_ || tolerance <= 0.0) return true;
  return any_moved({number, liquid, gas, solids_->solid.data(), volume.data(), known_liquid_.data(),
                    solids_->dry_area.data(), saturation_factor_, tolerance, asperity},
                   volume.size(), static_cast<std::size_t>(lanes));
}

ParticleTable ParticleTable::lane(std::size_t lane, std::size_t lanes) const {
  ParticleTable one = *this;
  for (auto* list : {&one.diameter, &one.inverse_diameter, &one.inverse_mass, &one.film, &one.liquid_fraction,
                     &one.porosity, &one.volume}) {
    for (std::size_t k = 0; k * lanes < list->size(); ++k) (*list)[k] = (*list)[k * lanes + lane];
    list->resize(list->size() / lanes);
  }
  return one;
}

LaneVector ParticleTable::wet(double least) const {
  LaneVector flags(liquid_.size());
  for (std::size_t k = 0; k < flags.size(); ++k) {
    const double all = solids_->solid[k] + liquid_[k] + gas_[k];
    flags[k] = external_liquid(liquid_[k], gas_[k], saturation_factor_) >= least * all ? 1.0 : 0.0;
  }
  return flags;
}

void ParticleTable::remember() {
  for (std::size_t k = 0; k < liquid_.size(); ++k)
    known_liquid_[k] = external_liquid(liquid_[k], gas_[k], saturation_factor_);
  known_ = true;
  fill({solids_->solid.data(), solids_->mass.data(), liquid_.data(), gas_.data(), diameter.data(),
        inverse_diameter.data(), inverse_mass.data(), film.data(), liquid_fraction.data(), porosity.data(),
        volume.data()},
       diameter.size(), saturation_factor_, liquid_density_, 0.5 * std::cbrt(6.0 / kPi));
}

}  // namespace granary::pbm
