#include "pbm_solver/model/sticking.hpp"

#include <math.h>  // not <cmath>: the vector forms belong to the global names

#include "common/every_width.hpp"
#include "common/units.hpp"

namespace granary::pbm {
namespace {

struct Mate {
  double inverse_diameter, inverse_mass, film;
};

struct Factors {
  double speed, inverse_asperity, ln_mean, inverse_width;
};

/// ln(1e-300) = -691: erfc is 0 there.
inline __attribute__((always_inline)) double sticking_share(const Factors& f, const Mate& p, double inverse_diameter,
                                                            double inverse_mass, double film) {
  const double a = p.inverse_diameter + inverse_diameter;
  const double square_over_mass = (p.inverse_mass + inverse_mass) / (a * a);  // d^2 / m, but for the 2 in f.speed
  const double films_over_asperity = (p.film + film) * f.inverse_asperity;
  const double depth = log(films_over_asperity > 1.0 ? films_over_asperity : 1.0);
  const double speed = f.speed * square_over_mass * depth;
  const double ln_speed = log(speed > 1e-300 ? speed : 1e-300);
  return 0.5 * erfc((f.ln_mean - ln_speed) * f.inverse_width);
}

GRANARY_EVERY_WIDTH
void one_lane(const Factors& f, WetParticles w, std::size_t p, std::size_t first, std::size_t n, double* beta) {
  const Mate mate{w.inverse_diameter[p], w.inverse_mass[p], w.film[p]};
  const double *diameters = w.inverse_diameter + first, *masses = w.inverse_mass + first, *films = w.film + first;
#pragma omp simd
  for (std::size_t q = 0; q < n; ++q) beta[q] *= sticking_share(f, mate, diameters[q], masses[q], films[q]);
}

GRANARY_EVERY_WIDTH
void eight_lanes(const Factors& f, WetParticles w, std::size_t p, std::size_t first, std::size_t n, double* beta) {
  const double *d_p = w.inverse_diameter + 8 * p, *m_p = w.inverse_mass + 8 * p, *h_p = w.film + 8 * p;
  for (std::size_t q = 0; q < n; ++q) {
    const std::size_t at = 8 * (first + q);
#pragma omp simd
    for (std::size_t l = 0; l < 8; ++l)
      beta[8 * q + l] *= sticking_share(f, {d_p[l], m_p[l], h_p[l]}, w.inverse_diameter[at + l], w.inverse_mass[at + l],
                                        w.film[at + l]);
  }
}

}  // namespace

StokesCriterion stokes_criterion(const Efficiency& efficiency, const Materials& materials,
                                 const SpeedDistribution& speeds) {
  const double speed_factor = 3.0 * kPi / 8.0 * materials.liquid_viscosity * (1.0 + 1.0 / efficiency.restitution);
  return {speed_factor, efficiency.asperity, speeds.ln_mean, speeds.ln_sigma};
}

void multiply_by_sticking_share(const StokesCriterion& c, WetParticles particles, std::size_t p, std::size_t first,
                                std::size_t n, std::size_t lanes, double* beta) {
  const Factors factors{2.0 * c.speed_factor, 0.5 / c.asperity, c.ln_mean, 1.0 / (c.ln_sigma * sqrt(2.0))};
  if (lanes == 1) return one_lane(factors, particles, p, first, n, beta);
  eight_lanes(factors, particles, p, first, n, beta);
}

}  // namespace granary::pbm
