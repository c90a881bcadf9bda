#include "pbm_solver/model/stokes_row.hpp"

#include <math.h>  // not <cmath>: the vector forms belong to the global names

// One body for every width of vector; the widest the machine has is taken when the program starts.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define GRANARY_EVERY_WIDTH __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define GRANARY_EVERY_WIDTH
#endif

namespace granary::pbm {

GRANARY_EVERY_WIDTH
void multiply_by_sticking_share(const StokesCriterion& criterion, WetParticles particles, std::size_t p, std::size_t n,
                                double* beta) {
  const double speed_factor = 2.0 * criterion.speed_factor, inverse_asperity = 0.5 / criterion.asperity;
  const double ln_mean = criterion.ln_mean, inverse_width = 1.0 / (criterion.ln_sigma * sqrt(2.0));
  const double inverse_diameter = particles.inverse_diameter[p], inverse_mass = particles.inverse_mass[p],
               film = particles.film[p];
  const double *diameters = particles.inverse_diameter, *masses = particles.inverse_mass, *films = particles.film;
#pragma omp simd
  for (std::size_t q = 0; q < n; ++q) {
    const double a = inverse_diameter + diameters[q];
    const double square_over_mass = (inverse_mass + masses[q]) / (a * a);  // d^2 / m, but for the 2 in speed_factor
    const double films_over_asperity = (film + films[q]) * inverse_asperity;
    const double depth = log(films_over_asperity > 1.0 ? films_over_asperity : 1.0);
    const double speed = speed_factor * square_over_mass * depth;
    const double ln_speed = log(speed > 1e-300 ? speed : 1e-300);  // ln(1e-300) = -691: erfc is 0 there
    beta[q] *= 0.5 * erfc((ln_mean - ln_speed) * inverse_width);
  }
}

}  // namespace granary::pbm
