// The share of collisions that stick.
#pragma once

#include <span>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/active_classes.hpp"

namespace granary::pbm {

/// Speed below which two wet particles stick [m/s], for many partners q of one particle p:
///
///   U_crit = 3 pi mu d^2 / (8 m) (1 + 1/e) ln(h / h_a),     d, m: harmonic means of the pair,  h: mean of the two films
///
/// and the share of collisions slower than that, with ln U normal (mean m_U, deviation s_U):
///
///   psi = 1/2 erfc(-(ln U_crit - m_U) / (s_U sqrt 2));   0 where h <= h_a.
///
/// Source: viscous Stokes criterion, [ennis1991]; docs/pbm_equations.md#efficiency.
struct StokesCriterion {
  double speed_factor = 0.0;  ///< 3 pi mu / 8 (1 + 1/e) [Pa s]
  double asperity = 0.0;      ///< h_a [m]
  double ln_mean = 0.0;       ///< m_U
  double ln_sigma = 1.0;      ///< s_U

  static StokesCriterion of(const Efficiency& efficiency, const Materials& materials, const SpeedDistribution& speeds);
  double critical_speed(double diameter_1, double mass_1, double film_1, double diameter_2, double mass_2, double film_2) const;
};

/// Multiplies beta[q] by the efficiency of p with q, for q = 0 .. beta.size() - 1.
class CollisionEfficiency {
 public:
  CollisionEfficiency(const Efficiency& efficiency, const Materials& materials, const SpeedDistribution& speeds);
  void apply(const ActiveClasses& classes, std::size_t p, std::span<double> beta) const;

 private:
  Efficiency efficiency_;
  StokesCriterion stokes_;
};

}  // namespace granary::pbm
