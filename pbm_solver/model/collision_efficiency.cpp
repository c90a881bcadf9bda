#include "pbm_solver/model/collision_efficiency.hpp"

#include "common/units.hpp"

namespace granary::pbm {

StokesCriterion stokes_criterion(const Efficiency& efficiency, const Materials& materials,
                                 const SpeedDistribution& speeds) {
  const double speed_factor = 3.0 * kPi / 8.0 * materials.liquid_viscosity * (1.0 + 1.0 / efficiency.restitution);
  return {speed_factor, efficiency.asperity, speeds.ln_mean, speeds.ln_sigma};
}

CollisionEfficiency::CollisionEfficiency(const Efficiency& efficiency, const Materials& materials,
                                         const SpeedDistribution& speeds)
    : efficiency_(efficiency), stokes_(stokes_criterion(efficiency, materials, speeds)) {}

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
      multiply_by_sticking_share(stokes_,
                                 {classes.inverse_diameter.data(), classes.inverse_mass.data(), classes.film.data()}, p,
                                 beta.size(), beta.data());
      return;
  }
}

}  // namespace granary::pbm
