// A kernel as a short sum of products, from a few of its rows: adaptive cross approximation.
#pragma once

#include <vector>

#include "pbm_solver/model/pair_kernel.hpp"

namespace granary::pbm {

/// beta(k,m) ~ sum_r u_r(k) u_r(m) - sum_r v_r(k) v_r(m) in one compartment, such that
///
///   |beta - approximation| <= tolerance C_km,      C: the collision rate without the efficiency
///
/// at every pair that was looked at: the diagonal, the smallest and the largest class's rows, and a regular sample of
/// others. Pivots are the largest errors, one class at a time or a pair of them where the error lies off the diagonal.
/// A last term lifts the approximation by the largest error left, times sqrt(C_kk C_mm), so that like particles have no
/// negative rate. Cost: one row of the kernel and O(rank n) for each pivot, instead of n^2 / 2 pairs. Source:
/// [bebendorf2000].
struct CrossApproximation {
  std::vector<std::vector<double>> plus, minus;  ///< u_r, v_r, shape (n_classes) each
  double error = 0.0;                            ///< the largest left, over C_km
  bool converged = false;                        ///< false: the tolerance was not reached within `most_terms`
};

/// @param kernel, particles  of a single lane
CrossApproximation approximate(const PairKernel& kernel, const ParticleTable& particles, std::size_t n_classes,
                               double tolerance, std::size_t most_terms);

}  // namespace granary::pbm
