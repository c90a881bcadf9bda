// How often a particle of a class breaks.
#pragma once

#include <vector>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/particles.hpp"

namespace granary::pbm {

/// Impact speed above which a granule breaks [m/s], from a critical Stokes deformation number and the viscous strength
/// of its liquid bridges:
///
///   U_br = 2 St* / rho  9/8 (1 - eps)^2 / eps^2  9 pi mu / (16 d_pp)         infinite without pores (eps = 0)
///
/// @param density   of the granule with its liquid and gas [kg/m^3]
/// @param porosity  (l + g) / V [-]
/// Source: docs/pbm_equations.md#breakage; [iveson2001] for St_def and the strength.
double breakage_speed(const Breakage& breakage, double viscosity, double density, double porosity);

/// Share of log-normal speeds above `speed`: 1/2 erfc((ln speed - m) / (s sqrt 2)).
double share_faster(const SpeedDistribution& speeds, double speed);

/// K = rate C_imp P(U > U_br) [1/s] in one compartment.
///   constant: C_imp P = 1/s.   linear: the solid volume over the reference volume, per second.   power: a power of it.
///   impact: the DEM's impact rate at the class's diameter (linear in ln d between class centres, the end class beyond
///   them) times the share of impacts faster than the breakage speed.
///   table: linear in ln of the solid volume between the table's parents, the end value beyond them.
class SelectionFunction {
 public:
  SelectionFunction(const PbmCase& pbm_case, int compartment);
  /// Of the mean particle at one place of a table, whose solids are `solid` [m^3].
  double operator()(double solid, const ParticleTable& particles, std::size_t at) const;

 private:
  double impact_rate(double diameter) const;
  double table_rate(double solid) const;

  Breakage breakage_;
  double viscosity_;
  double reference_volume_;
  double factor_ = 1.0;              ///< of the compartment's impacts
  std::vector<double> impact_rate_;  ///< [1/s], by DEM class
  std::vector<double> ln_diameter_;
  SpeedDistribution impact_speed_;
  std::vector<double> ln_solid_;  ///< of the table's parents
};

}  // namespace granary::pbm
