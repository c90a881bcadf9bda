// Runge-Kutta methods for y' = E(y) + B y: coefficients only. E is taken explicitly, the linear map B implicitly.
#pragma once

#include <array>
#include <cstddef>

namespace granary::pbm {

/// Stages of an additive method, all sums over j < i, h the step:
///
///   Y_0 = y,   Y_i - h gamma B Y_i = y + h sum_j (e_ij E(Y_j) + b_ij B Y_j),   y+ = Y_last
///   error = h sum_j (error_e_j E(Y_j) + error_b_j B Y_j)      y+ minus a result of order 2
///
/// The last stage is the result ("globally stiffly accurate"): what is fast leaves every step in balance. An explicit
/// method has gamma = 0: its B is 0 and E all there is. Order 3; E is evaluated `evaluations` times.
struct AdditiveMethod {
  static constexpr std::size_t kMost = 5;
  using Row = std::array<double, kMost>;
  std::size_t evaluations = 4;  ///< stages 0 .. evaluations - 1; the result is stage `evaluations`
  double gamma = 0.0;           ///< the same in every stage but the first
  std::array<Row, kMost> e{}, b{};
  Row error_e{}, error_b{};

  bool implicit() const { return gamma > 0.0; }
};

/// The strong-stability-preserving method with 4 stages: every stage is a mean of Euler steps of h/2, so that a state
/// stays positive as long as those do. Source: [kraaijevanger1991], embedded method [fekete2022].
AdditiveMethod explicit_method();

/// Stages at 0, 1/4, 2/3, 1/2, 1 of the step, four of them implicit. The implicit part is L-stable, and what decays
/// by it alone stays positive whatever the step: y+ = y (1 - z^2/8 - z^3/48) / (1 - z/4)^4, z = h lambda <= 0. (The
/// common methods of this kind change its sign once -z is above 2 to 3.) The error is against the midpoint rule at
/// stage 3. Derived here from the conditions of order 3 for pairs of methods [ascher1997], at gamma = 1/4 and small
/// coefficients; order, stability and sign in tests/unit/pbm_solver/integrator_test.cpp.
AdditiveMethod implicit_explicit_method();

}  // namespace granary::pbm
