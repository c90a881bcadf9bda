#include "pbm_solver/model/aggregation_operator.hpp"

#include <algorithm>
#include <cmath>

#include "common/units.hpp"

namespace granary::pbm {
namespace {

using Form = AggregationTables::Form;
constexpr std::size_t kMostTerms = 120;  // what then is left of the error is reported: kernel_error()

long pairs_of(const ClassGrid& grid) {
  const auto n = static_cast<long>(grid.size());
  return n * (n + 1) / 2;
}

bool has_table(const Aggregation& a) {
  return a.kernel == Aggregation::Kernel::dem || a.kernel == Aggregation::Kernel::table;
}

Form form_for(const PbmCase& c, const ClassGrid& grid) {
  using Kernel = Aggregation::Kernel;
  const Aggregation& a = *c.aggregation;
  const bool by_groups = a.kernel == Kernel::constant || (has_table(a) && a.lookup == Aggregation::Lookup::group);
  const bool pairwise = a.efficiency.model == Efficiency::Model::stokes;
  if (a.method == Aggregation::Method::pairs) return Form::pairs;
  if (!pairwise && by_groups) return Form::groups;
  if (!pairwise && !has_table(a)) return Form::factors;
  if (a.method == Aggregation::Method::low_rank) return Form::low_rank;
  const int lanes = lanes_for(c.compartments.count), blocks = (c.compartments.count + lanes - 1) / lanes;
  const double table = static_cast<double>(pairs_of(grid)) * lanes * blocks * sizeof(double);
  return table > AggregationTables::kLargestTable && c.kernel_tolerance > 0.0 ? Form::low_rank : Form::pairs;
}

/// Distinct highest partners along one axis, rising, and which of them each index has.
void list_tops(const SolidAxis& axis, std::vector<int>& tops, std::vector<int>& top_of) {
  for (int i = 0; i < axis.size(); ++i) tops.push_back(axis.highest_partner(i));
  std::sort(tops.begin(), tops.end());
  tops.erase(std::unique(tops.begin(), tops.end()), tops.end());
  for (int i = 0; i < axis.size(); ++i)
    top_of.push_back(
        static_cast<int>(std::lower_bound(tops.begin(), tops.end(), axis.highest_partner(i)) - tops.begin()));
}

const std::vector<double>& table_diameters(const PbmCase& c) {
  return c.aggregation->kernel == Aggregation::Kernel::dem ? c.dem->diameter : c.aggregation->table.diameter;
}

/// The efficiency the pair kernel has to know of: wet flags are weights of the particles instead.
PbmCase without_wet(PbmCase c) {
  if (c.aggregation->efficiency.model == Efficiency::Model::wet)
    c.aggregation->efficiency.model = Efficiency::Model::constant;
  return c;
}

}  // namespace

std::vector<int> size_groups(const PbmCase& c, const ClassGrid& grid, const std::vector<double>& diameter) {
  const double porosity = c.feed ? c.feed->porosity : 0.0;
  std::vector<int> group;
  for (const double s : grid.solid()) {
    const double ln_d = std::log(6.0 / kPi * s / (1.0 - porosity)) / 3.0;
    int nearest = 0;
    for (int g = 1; g < static_cast<int>(diameter.size()); ++g)
      if (std::abs(std::log(diameter[static_cast<std::size_t>(g)]) - ln_d) <
          std::abs(std::log(diameter[static_cast<std::size_t>(nearest)]) - ln_d))
        nearest = g;
    group.push_back(nearest);
  }
  return group;
}

AggregationTables::AggregationTables(const PbmCase& c, const ClassGrid& grid)
    : form(form_for(c, grid)), group(grid.size(), 0) {
  if (form == Form::groups && has_table(*c.aggregation)) {
    const std::vector<double>& diameter = table_diameters(c);
    group = size_groups(c, grid, diameter);
    n_groups = static_cast<int>(diameter.size());
  }
  if (form == Form::pairs)
    pairs.emplace(grid);
  else
    plan.emplace(grid, group, n_groups);
  list_tops(grid.axis(0), top_1, top_of_1);
  list_tops(grid.axis(1), top_2, top_of_2);
}

simd::GroupView AggregationTables::groups() const {
  return {n_groups,
          group.data(),
          static_cast<int>(top_1.size()),
          static_cast<int>(top_2.size()),
          top_1.data(),
          top_2.data(),
          top_of_1.data(),
          top_of_2.data()};
}

AggregationOperator::AggregationOperator(const AggregationTables& tables, const PbmCase& c, const ClassGrid& grid,
                                         const simd::GridView& view, int first, int count, int lanes)
    : tables_(&tables),
      do_(&simd::operations(lanes)),
      grid_(view),
      kernel_kind_(c.aggregation->kernel),
      by_particles_(kernel_kind_ == Aggregation::Kernel::shear ||
                    c.aggregation->efficiency.model == Efficiency::Model::stokes ||
                    (has_table(*c.aggregation) && tables.form != Form::groups)),
      tolerance_(c.kernel_tolerance),
      reference_volume_(c.reference_volume),
      efficiency_(c.aggregation->efficiency.model == Efficiency::Model::stokes ? 1.0 : c.aggregation->efficiency.value),
      n_(grid.size()),
      lanes_(static_cast<std::size_t>(lanes)),
      kernel_(without_wet(c), grid, first, count, lanes),
      solid_(grid.solid()) {
  const auto stride = static_cast<std::size_t>(moment_stride(lanes));
  slots_.resize((tables.plan ? static_cast<std::size_t>(tables.plan->slots()) : n_) * stride);
  if (tables.form == Form::factors) other_slots_.resize(slots_.size());
  if (tables.form == Form::low_rank) {
    minus_births_.resize(n_ * stride);
    for (int x = 0; x < count; ++x) single_.emplace_back(without_wet(c), grid, first + x, 1, 1);
  }
  for (auto* list : {&weight_, &other_weight_, &death_}) list->resize(n_ * lanes_);
  const auto group_scratch = static_cast<std::size_t>(simd::group_scratch(tables.groups(), lanes));
  scratch_.resize(tables.form == Form::pairs ? n_ * lanes_ : group_scratch);
  const RateTable table = tables.n_groups > 1 || has_table(*c.aggregation) ? rate_table_of(c) : RateTable();
  const auto groups = static_cast<std::size_t>(tables.n_groups);
  for (std::size_t a = 0; a < groups; ++a)
    for (std::size_t b = 0; b < groups; ++b)
      for (const double scale : kernel_.scale()) {
        double rate = 1.0;
        if (tables.form == Form::groups)
          rate = scale * efficiency_ *
                 (has_table(*c.aggregation) ? table(table_diameters(c)[a], table_diameters(c)[b]) : 1.0);
        coefficient_.push_back(rate);
      }
  if (!by_particles_) refresh(ParticleTable(SolidLanes(grid, c.materials, lanes), c.materials));
}

bool AggregationOperator::looks_at_particles() const { return by_particles_; }

void AggregationOperator::refresh(const ParticleTable& particles) {
  switch (tables_->form) {
    case Form::groups:
      return;
    case Form::pairs:
      kernel_.look_at(particles);
      beta_.resize(static_cast<std::size_t>(tables_->pairs->size()) * lanes_);
      row_.resize(n_ * lanes_);
      tables_->pairs->for_each_row([&](int k, int first, int count, long at, int step) {
        kernel_.row(particles, k, first, count, row_.data());
        for (int m = 0; m < count; ++m)
          std::copy_n(&row_[static_cast<std::size_t>(m) * lanes_], lanes_,
                      &beta_[static_cast<std::size_t>(at + long(m) * step) * lanes_]);
      });
      return;
    case Form::low_rank:
      return approximate_lanes(particles);
    case Form::factors:
      list_factors(particles);
      return;
  }
}

/// Each compartment has its own pivots; their factors then share the lanes, the largest rank deciding how many there
/// are.
void AggregationOperator::approximate_lanes(const ParticleTable& particles) {
  plus_.clear(), minus_.clear();
  kernel_error_ = 0.0;
  for (std::size_t l = 0; l < single_.size(); ++l) {
    const ParticleTable one = particles.lane(l, lanes_);
    single_[l].look_at(one);
    const CrossApproximation a = approximate(single_[l], one, n_, tolerance_, kMostTerms);
    kernel_error_ = std::max(kernel_error_, a.error);
    for (const bool sign : {true, false}) {
      const auto& terms = sign ? a.plus : a.minus;
      auto& into = sign ? plus_ : minus_;
      if (into.size() < terms.size()) into.resize(terms.size(), LaneVector(n_ * lanes_));
      for (std::size_t r = 0; r < terms.size(); ++r)
        for (std::size_t k = 0; k < n_; ++k) into[r][k * lanes_ + l] = terms[r][k];
    }
  }
}

/// C psi / V as f g' + g f': sum v + v', product v v' (one factor, f = g), shear (d^3 + d'^3) + 3 (d^2 d' + d d'^2).
void AggregationOperator::list_factors(const ParticleTable& particles) {
  const bool twice = kernel_kind_ == Aggregation::Kernel::shear;
  factors_.assign(twice ? 2 : 1, Factors{LaneVector(n_ * lanes_), LaneVector(n_ * lanes_)});
  for (std::size_t k = 0; k < n_; ++k)
    for (std::size_t l = 0; l < lanes_; ++l) {
      const std::size_t at = k * lanes_ + l;
      const double scale = kernel_.scale()[l] * efficiency_, v = solid_[k] / reference_volume_;
      if (kernel_kind_ == Aggregation::Kernel::sum) {
        factors_[0].f[at] = scale * v, factors_[0].g[at] = 1.0;
      } else if (kernel_kind_ == Aggregation::Kernel::product) {
        factors_[0].f[at] = std::sqrt(scale) * v;
      } else {
        const double d = particles.diameter[at];
        factors_[0].f[at] = scale * d * d * d, factors_[0].g[at] = 1.0;
        factors_[1].f[at] = 3.0 * scale * d * d, factors_[1].g[at] = d;
      }
    }
  if (kernel_kind_ == Aggregation::Kernel::product) factors_[0].g.clear();
}

/// participation x wet x factor, or null where all are 1.
const double* AggregationOperator::weights(const double* participation, const LaneVector* factor,
                                           LaneVector& into) const {
  if (participation == nullptr && factor == nullptr && wet_.empty()) return nullptr;
  for (std::size_t k = 0; k < into.size(); ++k) {
    double w = participation != nullptr ? participation[k] : 1.0;
    if (factor != nullptr) w *= (*factor)[k];
    if (!wet_.empty()) w *= wet_[k];
    into[k] = w;
  }
  return into.data();
}

void AggregationOperator::take_away(const double* weight, const LaneVector* factor, double sign, BlockFields state,
                                    BlockRates rates, double* loss) {
  if (sign < 0.0)
    for (double& d : death_) d = -d;
  do_->take_deaths(static_cast<int>(n_), death_.data(), weight, state.number, state.liquid, state.gas, rates.number,
                   rates.liquid, rates.gas);
  for (std::size_t k = 0; k < death_.size(); ++k)
    loss[k] += death_[k] * (factor != nullptr ? (*factor)[k] : 1.0) * (wet_.empty() ? 1.0 : wet_[k]);
}

void AggregationOperator::add_factors(const LaneVector& f, const LaneVector& g, BlockFields state,
                                      const double* participation, double sign, double* births, BlockRates rates,
                                      double* loss, double* above) {
  const int* code = tables_->plan->code().data();
  const simd::GroupView groups = tables_->groups();
  const auto lost = [&](const LaneVector& packs, const LaneVector& partners, const LaneVector& factor,
                        const double* weight) {
    std::fill(death_.begin(), death_.end(), 0.0);
    do_->deaths(grid_, groups, coefficient_.data(), packs.data(), partners.data(), scratch_.data(), death_.data(),
                above);
    take_away(weight, &factor, sign, state, rates, loss);
  };
  const double* weight_f = weights(participation, &f, weight_);
  do_->load(grid_, state.number, state.liquid, state.gas, weight_f, slots_.data());
  if (g.empty()) {
    do_->births(code, coefficient_.data(), slots_.data(), births);
    return lost(slots_, slots_, f, weight_f);
  }
  const double* weight_g = weights(participation, &g, other_weight_);
  do_->load(grid_, state.number, state.liquid, state.gas, weight_g, other_slots_.data());
  do_->births_of_two(code, coefficient_.data(), slots_.data(), other_slots_.data(), births);
  lost(slots_, other_slots_, f, weight_f);
  lost(other_slots_, slots_, g, weight_g);
}

void AggregationOperator::add(BlockFields state, const double* participation, double* births, BlockRates rates,
                              double* loss, double* above) {
  if (tables_->form == Form::factors) {
    for (const Factors& term : factors_)
      add_factors(term.f, term.g, state, participation, 1.0, births, rates, loss, above);
    return;
  }
  if (tables_->form == Form::low_rank) return add_low_rank(state, participation, births, rates, loss, above);
  std::fill(death_.begin(), death_.end(), 0.0);
  const double* weight = weights(participation, nullptr, weight_);
  do_->load(grid_, state.number, state.liquid, state.gas, weight, slots_.data());
  if (tables_->form == Form::groups) {
    do_->births(tables_->plan->code().data(), coefficient_.data(), slots_.data(), births);
    do_->deaths(grid_, tables_->groups(), coefficient_.data(), slots_.data(), slots_.data(), scratch_.data(),
                death_.data(), above);
  } else {
    do_->direct(grid_, tables_->pairs->view(beta_.data()), slots_.data(), scratch_.data(), births, death_.data(),
                above);
  }
  take_away(weight, nullptr, 1.0, state, rates, loss);
}

void AggregationOperator::add_low_rank(BlockFields state, const double* participation, double* births, BlockRates rates,
                                       double* loss, double* above) {
  for (const LaneVector& u : plus_) add_factors(u, {}, state, participation, 1.0, births, rates, loss, above);
  std::fill(minus_births_.begin(), minus_births_.end(), 0.0);
  alignas(64) std::array<double, kMoments * kLanes> minus_above{};
  for (const LaneVector& v : minus_)
    add_factors(v, {}, state, participation, -1.0, minus_births_.data(), rates, loss, minus_above.data());
  for (std::size_t k = 0; k < minus_births_.size(); ++k) births[k] -= minus_births_[k];
  for (int m = 0; m < moment_stride(static_cast<int>(lanes_)); ++m)
    above[m] -= minus_above[static_cast<std::size_t>(m)];
}

}  // namespace granary::pbm
