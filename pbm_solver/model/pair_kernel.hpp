// How often two particles aggregate, per pair: one function for each kernel, and the whole kernel row by row.
#pragma once

#include <span>
#include <vector>

#include "pbm_solver/case/pbm_case.hpp"
#include "pbm_solver/model/particles.hpp"
#include "pbm_solver/model/sticking.hpp"

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

/// A table of rate coefficients between size classes, carried to any two diameters:
///
///   C(d_p, d_q) = law(d_p, d_q) sum_ab w_a(d_p) w_b(d_q) C_ab / law(d_a, d_b)
///
/// with weights linear in ln d between class centres, and the end class beyond them; law = (d + d')^3 for the DEM's
/// rates (so that beyond the DEM's sizes they follow the orthokinetic law), 1 for a user's table. The table's values
/// come back at its centres; symmetric as C is.
class RateTable {
 public:
  enum class Law { orthokinetic, flat };
  RateTable() = default;
  RateTable(const std::vector<double>& diameter, const std::vector<std::vector<double>>& rate, Law law);

  std::span<const double> ln_diameter() const { return ln_diameter_; }
  double operator()(double d_p, double d_q) const;
  std::size_t classes() const { return ln_diameter_.size(); }
  Law law() const { return law_; }
  /// C_ab / law(d_a, d_b), b = 0 .. classes() - 1.
  const double* shape(int a) const { return &shape_[static_cast<std::size_t>(a) * classes()]; }

 private:
  Law law_ = Law::orthokinetic;
  std::vector<double> ln_diameter_;  ///< shape (n)
  std::vector<double> shape_;        ///< shape (n, n)
};

/// beta = rate C psi / V [1/s] for the compartments of one block. C: constant 1 m^3/s, or one of the functions above;
/// psi: the efficiency.
class PairKernel {
 public:
  /// @param first, count  the compartments of the block; lanes beyond them have beta = 0
  PairKernel(const PbmCase& pbm_case, const ClassGrid& grid, int first, int count, int lanes);

  /// To be called when the particles have changed.
  void look_at(const ParticleTable& particles);
  /// beta of class k with classes first .. first + count - 1, [count][lanes] [1/s].
  void row(const ParticleTable& particles, int k, int first, int count, double* beta) const;
  /// The same without the efficiency.
  void collisions(const ParticleTable& particles, int k, int first, int count, double* beta) const;
  /// rate (times the compartment's DEM factor) / V of each lane [1/m^3].
  std::span<const double> scale() const { return scale_; }

 private:
  void table_row(const ParticleTable& particles, int k, int first, int count, double* beta) const;

  Aggregation::Kernel kernel_;
  Efficiency efficiency_;
  StokesCriterion stokes_;
  double reference_volume_;  ///< [m^3]
  std::span<const double> solid_;
  std::size_t lanes_;
  LaneVector scale_;
  RateTable table_;
  std::vector<int> lower_;  ///< place of each particle in the table, [class][lanes]
  LaneVector to_upper_;
};

/// The table a case's kernel looks up, and its compartment factors; none for the other kernels.
RateTable rate_table_of(const PbmCase& pbm_case);
/// rate (times the compartment's DEM factor) / V [1/m^3].
double rate_scale(const PbmCase& pbm_case, int compartment);

}  // namespace granary::pbm
