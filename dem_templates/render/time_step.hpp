// Is the time step short enough for the contact law? Figures for `granary validate` and the report.
#pragma once

#include <optional>
#include <string>

#include "dem_templates/case/dem_case.hpp"

namespace granary::dem {

/// Times and overlaps of the smallest particle; every share is time_step over the time.
///
///   Rayleigh  T_R = pi R sqrt(rho / G) / (0.1631 nu + 0.8766)                    G = Y / (2 (1 + nu))
///   contact   T_c = 2.87 (m*^2 / (R* E*^2 v))^(1/5)                              v = impact speed, elastic Hertz
///   overlap   d   = (15 m* v^2 / (16 E* sqrt(R*)))^(2/5)                         elastic: restitution below 1 gives
///   less
///
///   bond      T_b = sqrt(m / (S_n A))                                            A: of a bond; where there are bonds
///
/// T_c and d are those of a particle hit by a blade: m* = m, R* = R, and E* of particle and wall in series.
/// Sources: docs/dem.md; checked against an integrated impact in time_step_test.cpp.
struct TimeStepFigures {
  double time_step = 0.0;                            ///< [s]
  double smallest_diameter = 0.0;                    ///< of the population and the feed [m]
  double impact_speed = 0.0;                         ///< measured, else the tip speed [m/s]
  double rayleigh_time = 0.0, rayleigh_share = 0.0;  ///< [s], [-]
  double contact_time = 0.0, contact_share = 0.0;    ///< [s], [-]
  double bond_time = 0.0, bond_share = 0.0;          ///< [s], [-]; 0 without bonds
  double impact_overlap = 0.0;                       ///< over the particle's radius [-]
};

inline constexpr double kLargestRayleighShare = 0.2;
inline constexpr double kLargestContactShare = 1.0 / 15.0;
/// A sphere with z bonds all around is stable up to about 0.9 / sqrt(z) of T_b; granary/bond itself looks closer.
inline constexpr double kLargestBondShare = 0.25;

TimeStepFigures time_step_figures(const DemCase& dem_case);

/// The step both rules allow [s].
double largest_time_step(const TimeStepFigures& figures);

/// What is wrong with the step, and the largest that is allowed; nothing if it is short enough.
std::optional<std::string> time_step_problem(const TimeStepFigures& figures);
/// Says if a single blade impact may exceed the guard's overlap, and the stiffness that would avoid it.
std::optional<std::string> overlap_warning(const TimeStepFigures& figures, const DemCase& dem_case);

/// time_step_problem() as an error of `file`, at /time_step.
Status check_time_step(const DemCase& dem_case, const std::string& file);

}  // namespace granary::dem
