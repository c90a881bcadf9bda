// The viscous Stokes criterion for many pairs at once: the one formula that costs more than all the rest, in a file of
// its own that is compiled for the vector forms of log and erfc.
#pragma once

#include <cstddef>

#include "pbm_solver/case/pbm_case.hpp"

namespace granary::pbm {

/// Two wet particles stick below the speed [m/s]
///
///   U_crit = 3 pi mu d^2 / (8 m) (1 + 1/e) ln(h / h_a),     d, m: harmonic means of the pair,  h: mean of their two
///   films
///
/// and with ln U normal (mean m_U, deviation s_U) this is the share of their collisions
///
///   psi = 1/2 erfc(-(ln U_crit - m_U) / (s_U sqrt 2));   0 where h <= h_a.
///
/// Source: [ennis1991]; docs/pbm_equations.md#efficiency.
struct StokesCriterion {
  double speed_factor = 0.0;  ///< 3 pi mu / 8 (1 + 1/e) [Pa s]
  double asperity = 1.0;      ///< h_a [m]
  double ln_mean = 0.0;       ///< m_U
  double ln_sigma = 1.0;      ///< s_U
};

/// The criterion of these settings.
StokesCriterion stokes_criterion(const Efficiency& efficiency, const Materials& materials,
                                 const SpeedDistribution& speeds);

/// Particles as arrays: 1/d [1/m], 1/m [1/kg], film h [m].
struct WetParticles {
  const double* inverse_diameter;
  const double* inverse_mass;
  const double* film;
};

/// beta[q] *= psi(p, q) for q = first .. first + n - 1, of `lanes` compartments side by side: all arrays
/// [class][lanes], beta from class `first` on. All inputs must be finite.
void multiply_by_sticking_share(const StokesCriterion& criterion, WetParticles particles, std::size_t p,
                                std::size_t first, std::size_t n, std::size_t lanes, double* beta);

}  // namespace granary::pbm
