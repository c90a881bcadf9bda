// How often two particles of given classes aggregate, per pair of particles: one function for each kernel.
#pragma once

#include <span>
#include <vector>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/active_classes.hpp"
#include "pbm_solver/model/collision_efficiency.hpp"

namespace granary::pbm {

/// Collision rate coefficients between two solid volumes [m^3], in units of a reference volume. Exact solutions exist
/// for these.
inline double sum_kernel(double v, double w, double reference) { return (v + w) / reference; }
inline double product_kernel(double v, double w, double reference) { return v / reference * (w / reference); }
/// Orthokinetic: proportional to (d_p + d_q)^3 [m^3]; fits high-shear DEM data [gantt2006].
inline double shear_kernel(double d_p, double d_q) {
  const double both = d_p + d_q;
  return both * both * both;
}

/// DEM collision rates between size classes, carried to any two diameters:
///
///   C(d_p, d_q) = (d_p + d_q)^3 sum_ab w_a(d_p) w_b(d_q) C_ab / (d_a + d_b)^3
///
/// with weights linear in ln d between class centres, and the end class beyond them. So the table's values come back at
/// the centres, and beyond the DEM's sizes the coefficient follows the orthokinetic law. Symmetric as C is.
class DemKernel {
 public:
  DemKernel() = default;
  explicit DemKernel(const DemRates& dem);
  std::span<const double> ln_diameter() const { return ln_diameter_; }
  double operator()(double d_p, double d_q) const;
  /// The same for one p and q = 0 .. rate.size() - 1.
  void row(const ActiveClasses& classes, std::size_t p, std::span<double> rate) const;

 private:
  const double* shape(int a) const { return &shape_[static_cast<std::size_t>(a) * ln_diameter_.size()]; }
  std::vector<double> ln_diameter_;  ///< shape (n)
  std::vector<double> shape_;        ///< C_ab / (d_a + d_b)^3, shape (n, n)
};

/// beta = rate C psi / V [1/s] in one compartment. C: constant 1 m^3/s, or one of the functions above; psi: the
/// efficiency.
class AggregationKernel {
 public:
  AggregationKernel(const PbmCase& pbm_case, int compartment);
  /// beta of active class p with the active classes q = 0 .. beta.size() - 1.
  void row(const ActiveClasses& classes, std::size_t p, std::span<double> beta) const;

 private:
  Aggregation::Kernel kernel_;
  double scale_;             ///< rate (times the compartment's DEM factor) / V [1/m^3]
  double reference_volume_;  ///< [m^3]
  DemKernel dem_;
  CollisionEfficiency efficiency_;
};

}  // namespace granary::pbm
