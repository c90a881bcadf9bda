#include "pbm_solver/model/collision_efficiency.hpp"

#include <math.h>  // not only <cmath>: the vector forms of log and erfc belong to the global names

#include <cmath>

#include "common/units.hpp"

// One body for every width of vector; the widest the machine has is taken when the program starts.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define GRANARY_EVERY_WIDTH __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define GRANARY_EVERY_WIDTH
#endif

namespace granary::pbm {

/// psi of one particle with each of n partners, multiplied into beta. Two logarithms and one erfc a pair.
GRANARY_EVERY_WIDTH
void multiply_stokes(std::size_t n, double speed_factor, double inverse_asperity, double ln_mean, double inverse_width,
                     double inverse_diameter_p, double inverse_mass_p, double film_p, const double* inverse_diameter,
                     const double* inverse_mass, const double* film, double* beta) {
#pragma omp simd
  for (std::size_t q = 0; q < n; ++q) {
    const double a = inverse_diameter_p + inverse_diameter[q];
    const double square_over_mass = 2.0 * (inverse_mass_p + inverse_mass[q]) / (a * a);
    const double thickness = 0.5 * (film_p + film[q]) * inverse_asperity;
    const double depth = log(thickness > 1.0 ? thickness : 1.0);
    const double speed = speed_factor * square_over_mass * depth;
    const double ln_speed = log(speed > 1e-300 ? speed : 1e-300);
    beta[q] *= 0.5 * erfc((ln_mean - ln_speed) * inverse_width);
  }
}

StokesCriterion StokesCriterion::of(const Efficiency& efficiency, const Materials& materials, const SpeedDistribution& speeds) {
  StokesCriterion s;
  s.speed_factor = 3.0 * kPi / 8.0 * materials.liquid_viscosity * (1.0 + 1.0 / efficiency.restitution);
  s.asperity = efficiency.asperity;
  s.ln_mean = speeds.ln_mean;
  s.ln_sigma = speeds.ln_sigma;
  return s;
}

double StokesCriterion::critical_speed(double diameter_1, double mass_1, double film_1, double diameter_2, double mass_2,
                                       double film_2) const {
  const double d = 2.0 / (1.0 / diameter_1 + 1.0 / diameter_2);
  const double m = 2.0 / (1.0 / mass_1 + 1.0 / mass_2);
  const double film = 0.5 * (film_1 + film_2);
  return film > asperity ? speed_factor * d * d / m * log(film / asperity) : 0.0;
}

CollisionEfficiency::CollisionEfficiency(const Efficiency& efficiency, const Materials& materials, const SpeedDistribution& speeds)
    : efficiency_(efficiency), stokes_(StokesCriterion::of(efficiency, materials, speeds)) {}

void CollisionEfficiency::apply(const ActiveClasses& classes, std::size_t p, std::span<double> beta) const {
  switch (efficiency_.model) {
    case Efficiency::Model::constant:
      if (efficiency_.value == 1.0) return;
      for (double& b : beta) b *= efficiency_.value;
      return;
    case Efficiency::Model::wet: {
      const double least = efficiency_.least_liquid_fraction;
      const double if_wet = classes.liquid_fraction[p] >= least ? efficiency_.value : 0.0;
      for (std::size_t q = 0; q < beta.size(); ++q) beta[q] *= classes.liquid_fraction[q] >= least ? if_wet : 0.0;
      return;
    }
    case Efficiency::Model::stokes:
      multiply_stokes(beta.size(), stokes_.speed_factor, 1.0 / stokes_.asperity, stokes_.ln_mean,
                      1.0 / (stokes_.ln_sigma * std::sqrt(2.0)), classes.inverse_diameter[p], classes.inverse_mass[p],
                      classes.film[p], classes.inverse_diameter.data(), classes.inverse_mass.data(), classes.film.data(), beta.data());
      return;
  }
}

}  // namespace granary::pbm
