#include "pbm_solver/model/pair_kernel.hpp"

#include <cmath>

namespace granary::pbm {
namespace {

double between(const double* values, ClassPosition at) {
  return at.to_upper == 0.0 ? values[at.lower]
                            : (1.0 - at.to_upper) * values[at.lower] + at.to_upper * values[at.lower + 1];
}

bool has_table(Aggregation::Kernel kernel) {
  return kernel == Aggregation::Kernel::dem || kernel == Aggregation::Kernel::table;
}

}  // namespace

RateTable::RateTable(const std::vector<double>& diameter, const std::vector<std::vector<double>>& rate, Law law)
    : law_(law) {
  const std::size_t n = diameter.size();
  for (const double d : diameter) ln_diameter_.push_back(std::log(d));
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) {
      const double mean = 0.5 * (rate[a][b] + rate[b][a]);
      shape_.push_back(law == Law::orthokinetic ? mean / shear_kernel(diameter[a], diameter[b]) : mean);
    }
}

double RateTable::operator()(double d_p, double d_q) const {
  const ClassPosition p = position_of(ln_diameter_, std::log(d_p)), q = position_of(ln_diameter_, std::log(d_q));
  const double low = between(shape(p.lower), q);
  const double high = p.to_upper == 0.0 ? low : between(shape(p.lower + 1), q);
  const double shape = (1.0 - p.to_upper) * low + p.to_upper * high;
  return law_ == Law::orthokinetic ? shear_kernel(d_p, d_q) * shape : shape;
}

RateTable rate_table_of(const PbmCase& c) {
  switch (c.aggregation->kernel) {
    case Aggregation::Kernel::dem:
      return RateTable(c.dem->diameter, c.dem->collision_rate, RateTable::Law::orthokinetic);
    case Aggregation::Kernel::table:
      return RateTable(c.aggregation->table.diameter, c.aggregation->table.rate, RateTable::Law::flat);
    default:
      return {};
  }
}

double rate_scale(const PbmCase& c, int compartment) {
  const auto x = static_cast<std::size_t>(compartment);
  const bool given = c.aggregation->kernel == Aggregation::Kernel::dem && !c.dem->compartment_factor.empty();
  return c.aggregation->rate * (given ? c.dem->compartment_factor[x] : 1.0) / c.compartments.volume[x];
}

PairKernel::PairKernel(const PbmCase& c, const ClassGrid& grid, int first, int count, int lanes)
    : kernel_(c.aggregation->kernel),
      efficiency_(c.aggregation->efficiency),
      stokes_(stokes_criterion(efficiency_, c.materials, c.dem ? c.dem->collision_speed : SpeedDistribution{})),
      reference_volume_(c.reference_volume),
      solid_(grid.solid()),
      lanes_(static_cast<std::size_t>(lanes)),
      scale_(lanes_, 0.0),
      table_(rate_table_of(c)) {
  for (int x = 0; x < count; ++x) scale_[static_cast<std::size_t>(x)] = rate_scale(c, first + x);
}

void PairKernel::look_at(const ParticleTable& particles) {
  if (!has_table(kernel_)) return;
  lower_.resize(particles.diameter.size());
  to_upper_.resize(particles.diameter.size());
  for (std::size_t k = 0; k < lower_.size(); ++k) {
    const ClassPosition at = position_of(table_.ln_diameter(), std::log(particles.diameter[k]));
    lower_[k] = at.lower, to_upper_[k] = at.to_upper;
  }
}

void PairKernel::table_row(const ParticleTable& particles, int k, int first, int count, double* beta) const {
  const std::size_t n = table_.classes();
  thread_local std::vector<double> blend;
  for (std::size_t l = 0; l < lanes_; ++l) {
    const std::size_t p = static_cast<std::size_t>(k) * lanes_ + l;
    const double to_upper = to_upper_[p];
    const double* low = table_.shape(lower_[p]);
    const double* high = to_upper == 0.0 ? low : table_.shape(lower_[p] + 1);
    blend.assign(n + 1, 0.0);  // one more, so that the end class may look at a neighbour of weight 0
    for (std::size_t b = 0; b < n; ++b) blend[b] = (1.0 - to_upper) * low[b] + to_upper * high[b];
    const double d_p = particles.diameter[p];
    const bool law = table_.law() == RateTable::Law::orthokinetic;
    for (std::size_t c = 0; c < static_cast<std::size_t>(count); ++c) {
      const std::size_t q = (static_cast<std::size_t>(first) + c) * lanes_ + l;
      const auto at = static_cast<std::size_t>(lower_[q]);
      const double shape = (1.0 - to_upper_[q]) * blend[at] + to_upper_[q] * blend[at + 1];
      beta[c * lanes_ + l] = law ? shear_kernel(d_p, particles.diameter[q]) * shape : shape;
    }
  }
}

void PairKernel::collisions(const ParticleTable& particles, int k, int first, int count, double* beta) const {
  const auto p = static_cast<std::size_t>(k), from = static_cast<std::size_t>(first),
             n = static_cast<std::size_t>(count);
  switch (kernel_) {
    case Aggregation::Kernel::constant:
      for (std::size_t at = 0; at < n * lanes_; ++at) beta[at] = 1.0;
      break;
    case Aggregation::Kernel::sum:
    case Aggregation::Kernel::product:
      for (std::size_t q = 0; q < n; ++q) {
        const double v = solid_[p], w = solid_[from + q];
        const double rate = kernel_ == Aggregation::Kernel::sum ? sum_kernel(v, w, reference_volume_)
                                                                : product_kernel(v, w, reference_volume_);
        for (std::size_t l = 0; l < lanes_; ++l) beta[q * lanes_ + l] = rate;
      }
      break;
    case Aggregation::Kernel::shear:
      for (std::size_t q = 0; q < n; ++q)
        for (std::size_t l = 0; l < lanes_; ++l)
          beta[q * lanes_ + l] =
              shear_kernel(particles.diameter[p * lanes_ + l], particles.diameter[(from + q) * lanes_ + l]);
      break;
    case Aggregation::Kernel::dem:
    case Aggregation::Kernel::table:
      table_row(particles, k, first, count, beta);
      break;
  }
  for (std::size_t q = 0; q < n; ++q)
    for (std::size_t l = 0; l < lanes_; ++l) beta[q * lanes_ + l] *= scale_[l];
}

void PairKernel::row(const ParticleTable& particles, int k, int first, int count, double* beta) const {
  collisions(particles, k, first, count, beta);
  const auto p = static_cast<std::size_t>(k), from = static_cast<std::size_t>(first),
             n = static_cast<std::size_t>(count);
  switch (efficiency_.model) {
    case Efficiency::Model::constant:
      if (efficiency_.value == 1.0) return;
      for (std::size_t at = 0; at < n * lanes_; ++at) beta[at] *= efficiency_.value;
      return;
    case Efficiency::Model::wet:
      for (std::size_t q = 0; q < n; ++q)
        for (std::size_t l = 0; l < lanes_; ++l) {
          const bool both = particles.liquid_fraction[p * lanes_ + l] >= efficiency_.least_liquid_fraction &&
                            particles.liquid_fraction[(from + q) * lanes_ + l] >= efficiency_.least_liquid_fraction;
          beta[q * lanes_ + l] *= both ? efficiency_.value : 0.0;
        }
      return;
    case Efficiency::Model::stokes:
      multiply_by_sticking_share(
          stokes_, {particles.inverse_diameter.data(), particles.inverse_mass.data(), particles.film.data()}, p, from,
          n, lanes_, beta);
      return;
  }
}

}  // namespace granary::pbm
