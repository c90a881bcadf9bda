#include "pbm_solver/model/selection_function.hpp"

#include <cmath>
#include <limits>

#include "common/units.hpp"

namespace granary::pbm {

double breakage_speed(const Breakage& breakage, double viscosity, double density, double porosity) {
  if (!(porosity > 0.0)) return std::numeric_limits<double>::infinity();
  const double packing = (1.0 - porosity) / porosity;
  return 2.0 * breakage.critical_stokes_deformation / density * 9.0 / 8.0 * packing * packing * 9.0 * kPi * viscosity /
         (16.0 * breakage.primary_diameter);
}

double share_faster(const SpeedDistribution& speeds, double speed) {
  return 0.5 * std::erfc((std::log(speed) - speeds.ln_mean) / (speeds.ln_sigma * std::sqrt(2.0)));
}

SelectionFunction::SelectionFunction(const PbmCase& c, int compartment)
    : breakage_(*c.breakage), viscosity_(c.materials.liquid_viscosity), reference_volume_(c.reference_volume) {
  for (const double solid : breakage_.table.solid) ln_solid_.push_back(std::log(solid));
  if (breakage_.selection != Breakage::Selection::impact) return;
  if (!c.dem->compartment_factor.empty()) factor_ = c.dem->compartment_factor[static_cast<std::size_t>(compartment)];
  impact_rate_ = c.dem->impact_rate;
  impact_speed_ = c.dem->impact_speed;
  for (const double d : c.dem->diameter) ln_diameter_.push_back(std::log(d));
}

double SelectionFunction::impact_rate(double diameter) const {
  const ClassPosition at = position_of(ln_diameter_, std::log(diameter));
  const double low = impact_rate_[static_cast<std::size_t>(at.lower)];
  if (at.to_upper == 0.0) return factor_ * low;
  return factor_ * ((1.0 - at.to_upper) * low + at.to_upper * impact_rate_[static_cast<std::size_t>(at.lower) + 1]);
}

double SelectionFunction::table_rate(double solid) const {
  const ClassPosition at = position_of(ln_solid_, std::log(solid));
  const auto lower = static_cast<std::size_t>(at.lower);
  const double low = breakage_.table.rate[lower];
  return at.to_upper == 0.0 ? low : (1.0 - at.to_upper) * low + at.to_upper * breakage_.table.rate[lower + 1];
}

double SelectionFunction::operator()(double solid, const ParticleTable& particles, std::size_t at) const {
  switch (breakage_.selection) {
    case Breakage::Selection::constant:
      return breakage_.rate;
    case Breakage::Selection::linear:
      return breakage_.rate * solid / reference_volume_;
    case Breakage::Selection::power:
      return breakage_.rate * std::pow(solid / reference_volume_, breakage_.exponent);
    case Breakage::Selection::table:
      return breakage_.rate * table_rate(solid);
    case Breakage::Selection::impact: {
      const double density = 1.0 / (particles.inverse_mass[at] * particles.volume[at]);
      const double speed = breakage_speed(breakage_, viscosity_, density, particles.porosity[at]);
      return breakage_.rate * impact_rate(particles.diameter[at]) * share_faster(impact_speed_, speed);
    }
  }
  return 0.0;
}

}  // namespace granary::pbm
