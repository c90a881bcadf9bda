#include "pbm_solver/model/aggregation_kernel.hpp"

#include <cmath>

namespace granary::pbm {
namespace {

double compartment_factor(const PbmCase& c, int compartment) {
  const bool given = c.aggregation->kernel == Aggregation::Kernel::dem && !c.dem->compartment_factor.empty();
  return given ? c.dem->compartment_factor[static_cast<std::size_t>(compartment)] : 1.0;
}

double between(const double* values, ClassPosition at) {
  return at.to_upper == 0.0 ? values[at.lower]
                            : (1.0 - at.to_upper) * values[at.lower] + at.to_upper * values[at.lower + 1];
}

}  // namespace

DemKernel::DemKernel(const DemRates& dem) {
  const std::size_t n = dem.diameter.size();
  for (const double d : dem.diameter) ln_diameter_.push_back(std::log(d));
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) {
      const double rate = 0.5 * (dem.collision_rate[a][b] + dem.collision_rate[b][a]);
      shape_.push_back(rate / shear_kernel(dem.diameter[a], dem.diameter[b]));
    }
}

double DemKernel::operator()(double d_p, double d_q) const {
  const ClassPosition p = position_of(ln_diameter_, d_p), q = position_of(ln_diameter_, d_q);
  const double low = between(shape(p.lower), q);
  const double high = p.to_upper == 0.0 ? low : between(shape(p.lower + 1), q);
  return shear_kernel(d_p, d_q) * ((1.0 - p.to_upper) * low + p.to_upper * high);
}

void DemKernel::row(const ActiveClasses& classes, std::size_t p, std::span<double> rate) const {
  const std::size_t n = ln_diameter_.size();
  const ClassPosition at = classes.dem[p];
  const double* low = shape(at.lower);
  const double* high = at.to_upper == 0.0 ? low : shape(at.lower + 1);
  thread_local std::vector<double> blend;
  blend.assign(n + 1, 0.0);  // one more, so that the end class may look at a neighbour of weight 0
  for (std::size_t b = 0; b < n; ++b) blend[b] = (1.0 - at.to_upper) * low[b] + at.to_upper * high[b];
  const double d_p = classes.diameter[p];
  for (std::size_t q = 0; q < rate.size(); ++q) {
    const ClassPosition other = classes.dem[q];
    const double shape = (1.0 - other.to_upper) * blend[other.lower] + other.to_upper * blend[other.lower + 1];
    rate[q] = shear_kernel(d_p, classes.diameter[q]) * shape;
  }
}

AggregationKernel::AggregationKernel(const PbmCase& c, int compartment)
    : kernel_(c.aggregation->kernel),
      scale_(c.aggregation->rate * compartment_factor(c, compartment) /
             c.compartments.volume[static_cast<std::size_t>(compartment)]),
      reference_volume_(c.reference_volume),
      dem_(kernel_ == Aggregation::Kernel::dem ? DemKernel(*c.dem) : DemKernel()),
      efficiency_(c.aggregation->efficiency, c.materials, c.dem ? c.dem->collision_speed : SpeedDistribution{}) {}

void AggregationKernel::row(const ActiveClasses& classes, std::size_t p, std::span<double> beta) const {
  const std::size_t n = beta.size();
  const double v = classes.solid[p], d = classes.diameter[p];
  switch (kernel_) {
    case Aggregation::Kernel::constant:
      for (double& b : beta) b = 1.0;
      break;
    case Aggregation::Kernel::sum:
      for (std::size_t q = 0; q < n; ++q) beta[q] = sum_kernel(v, classes.solid[q], reference_volume_);
      break;
    case Aggregation::Kernel::product:
      for (std::size_t q = 0; q < n; ++q) beta[q] = product_kernel(v, classes.solid[q], reference_volume_);
      break;
    case Aggregation::Kernel::shear:
      for (std::size_t q = 0; q < n; ++q) beta[q] = shear_kernel(d, classes.diameter[q]);
      break;
    case Aggregation::Kernel::dem:
      dem_.row(classes, p, beta);
      break;
  }
  for (double& b : beta) b *= scale_;
  efficiency_.apply(classes, p, beta);
}

}  // namespace granary::pbm
