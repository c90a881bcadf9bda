#include "pbm_solver/model/compartment_block.hpp"

#include <algorithm>
#include <cmath>

#include "pbm_solver/model/consolidation.hpp"

namespace granary::pbm {

CompartmentBlock::CompartmentBlock(const ModelTables& tables, int first, int count)
    : tables_(&tables),
      do_(&simd::operations(tables.lanes)),
      first_(first),
      count_(count),
      n_(tables.grid.size()),
      lanes_(static_cast<std::size_t>(tables.lanes)),
      particles_(tables.solids, tables.pbm_case.materials),
      loss_rate_(n_ * lanes_) {
  const PbmCase& c = tables.pbm_case;
  if (tables.aggregation) {
    aggregation_.emplace(*tables.aggregation, c, tables.grid, tables.view, first, count, tables.lanes);
    births_.resize(n_ * static_cast<std::size_t>(moment_stride(tables.lanes)));
    by_particles_ = aggregation_->looks_at_particles();
    wet_ = c.aggregation->efficiency.model == Efficiency::Model::wet;
    asperity_ = c.aggregation->efficiency.asperity;
  }
  if (c.breakage) {
    by_particles_ = by_particles_ || c.breakage->selection == Breakage::Selection::impact;
    for (int x = 0; x < count; ++x) selection_.emplace_back(c, first + x);
    selection_rate_.resize(n_ * lanes_);
    scratch_.resize(2 * n_ * lanes_);
    taking_part_.resize(n_ * lanes_);
  }
  turnover_.resize(lanes_);
  if (c.compartments.residence_time)
    std::fill_n(turnover_.begin(), count, c.compartments.count / *c.compartments.residence_time);
  if (!by_particles_) {
    particles_.remember();
    look_up_selection();
  }
}

/// Classes that cannot be divided do not break.
void CompartmentBlock::look_up_selection() {
  if (selection_.empty()) return;
  for (std::size_t k = 0; k < n_; ++k)
    for (std::size_t l = 0; l < static_cast<std::size_t>(count_); ++l) {
      const std::size_t at = k * lanes_ + l;
      selection_rate_[at] =
          tables_->fragments->divisible(k) ? selection_[l](tables_->solids.solid[at], particles_, at) : 0.0;
    }
}

void CompartmentBlock::begin_step(const double* state) {
  if (!wet_) return;
  particles_.look_at(state, state + n_ * lanes_, state + 2 * n_ * lanes_);
  aggregation_->set_wet(particles_.wet(tables_->pbm_case.aggregation->efficiency.least_liquid_fraction));
}

bool CompartmentBlock::moved(const double* state) const {
  if (!by_particles_) return false;
  const bool cheap = aggregation_ && aggregation_->looks_at_particles() && aggregation_->follows_particles();
  return cheap || particles_.moved(state, state + n_ * lanes_, state + 2 * n_ * lanes_,
                                   tables_->pbm_case.kernel_tolerance, asperity_, tables_->lanes);
}

void CompartmentBlock::look_at_particles(const double* state) {
  if (!by_particles_) return;
  particles_.look_at(state, state + n_ * lanes_, state + 2 * n_ * lanes_);
  particles_.remember();
  if (aggregation_ && aggregation_->looks_at_particles()) aggregation_->refresh(particles_);
  look_up_selection();
}

void CompartmentBlock::rates(const double* state, const double* participation, const double* carry, Inputs inputs,
                             bool breakage, double* rates) {
  const simd::FlushDenormals flush;
  std::fill_n(rates, stride(), 0.0);
  std::fill(loss_rate_.begin(), loss_rate_.end(), 0.0);
  if (aggregation_) add_aggregation(state, participation, rates);
  if (breakage && !selection_.empty()) {
    for (std::size_t q = 0; q < 3; ++q) {
      const double* field = state + q * n_ * lanes_;
      if (participation != nullptr) {
        for (std::size_t k = 0; k < n_ * lanes_; ++k) taking_part_[k] = participation[k] * field[k];
        field = taking_part_.data();
      }
      do_->add_breakage(tables_->view, tables_->fragments->view(), selection_rate_.data(),
                        q == 0 ? nullptr : tables_->grid.solid().data(), 1.0, field, scratch_.data(),
                        rates + q * n_ * lanes_);
    }
    for (std::size_t k = 0; k < n_ * lanes_; ++k) loss_rate_[k] += selection_rate_[k];
  }
  if (tables_->pbm_case.consolidation) consolidate(state, rates);
  if (inputs.feed && holds(0)) add_feed(rates);
  if (inputs.spray && holds(tables_->pbm_case.spray->compartment)) add_spray(state, rates);
  if (tables_->pbm_case.compartments.residence_time) add_flow(state, carry, rates);
}

void CompartmentBlock::add_aggregation(const double* state, const double* participation, double* rates) {
  const std::size_t m = n_ * lanes_;
  std::fill(births_.begin(), births_.end(), 0.0);
  alignas(64) std::array<double, kMoments * kLanes> above{};
  aggregation_->add({state, state + m, state + 2 * m}, participation, births_.data(), {rates, rates + m, rates + 2 * m},
                    loss_rate_.data(), above.data());
  do_->share(tables_->view, births_.data(), rates, rates + m, rates + 2 * m);
  for (std::size_t l = 0; l < lanes_; ++l) {
    flows(rates, ledger::kOversizeNumber)[l] = above[l];
    for (std::size_t q = 0; q < 4; ++q) flows(rates, ledger::kOversize + q)[l] = above[(q + 1) * lanes_ + l];
  }
}

void CompartmentBlock::add_breakage(double factor, const double* state, double* out) {
  const simd::FlushDenormals flush;
  for (std::size_t q = 0; q < 3; ++q)
    do_->add_breakage(tables_->view, tables_->fragments->view(), selection_rate_.data(),
                      q == 0 ? nullptr : tables_->grid.solid().data(), factor, state + q * n_ * lanes_, scratch_.data(),
                      out + q * n_ * lanes_);
}

void CompartmentBlock::solve_breakage(double gamma, double* state) {
  const simd::FlushDenormals flush;
  for (std::size_t q = 0; q < 3; ++q)
    do_->solve_breakage(tables_->view, tables_->fragments->view(), selection_rate_.data(),
                        q == 0 ? nullptr : tables_->grid.solid().data(), gamma, scratch_.data(),
                        state + q * n_ * lanes_);
}

void CompartmentBlock::consolidate(const double* state, double* rates) const {
  const PbmCase& c = tables_->pbm_case;
  const std::size_t m = n_ * lanes_;
  for (std::size_t k = 0; k < m; ++k) {
    const double number = state[k];
    if (!(number > 0.0)) continue;
    const double lost =
        number * consolidation_rate(*c.consolidation, c.materials.saturation_factor, tables_->solids.solid[k],
                                    state[m + k] / number, state[2 * m + k] / number);
    rates[2 * m + k] -= lost;
    flows(rates, ledger::kConsolidated)[k % lanes_] += lost;
  }
}

/// Fed particles: dry, with gas = solid porosity / (1 - porosity).
void CompartmentBlock::add_feed(double* rates) const {
  const Feed& feed = *tables_->pbm_case.feed;
  const auto lane = static_cast<std::size_t>(-first_);
  const double gas_per_solid = feed.porosity / (1.0 - feed.porosity);
  for (const ClassRate& c : feed.classes) {
    const std::size_t k = tables_->grid.index(c.i, c.j);
    const double gas = c.rate * tables_->grid.solid()[k] * gas_per_solid;
    rates[k * lanes_ + lane] += c.rate;
    rates[(2 * n_ + k) * lanes_ + lane] += gas;
    flows(rates, ledger::kIn)[lane] += c.rate * tables_->grid.solid_1()[k];
    flows(rates, ledger::kIn + 1)[lane] += c.rate * tables_->grid.solid_2()[k];
    flows(rates, ledger::kIn + 3)[lane] += gas;
  }
}

/// Each particle takes liquid in proportion to its solid volume. An empty compartment takes none.
void CompartmentBlock::add_spray(const double* state, double* rates) const {
  const Spray& spray = *tables_->pbm_case.spray;
  const auto lane = static_cast<std::size_t>(spray.compartment - first_);
  const std::span<const double> solid = tables_->grid.solid();
  double held = 0.0;
  for (std::size_t k = 0; k < n_; ++k) held += solid[k] * state[k * lanes_ + lane];
  if (!(held > 0.0)) return;
  for (std::size_t k = 0; k < n_; ++k)
    rates[(n_ + k) * lanes_ + lane] += spray.rate * (solid[k] * state[k * lanes_ + lane] / held);
  flows(rates, ledger::kIn + 2)[lane] += spray.rate;
}

/// Out of each compartment and into the next at k = count / residence time [1/s] of its content.
void CompartmentBlock::add_flow(const double* state, const double* carry, double* rates) const {
  for (std::size_t q = 0; q < 3; ++q)
    do_->flow(static_cast<int>(n_), turnover_.data(), state + q * n_ * lanes_,
              carry != nullptr ? carry + q * n_ : nullptr, rates + q * n_ * lanes_);
  if (!holds(tables_->pbm_case.compartments.count - 1)) return;
  const auto lane = static_cast<std::size_t>(tables_->pbm_case.compartments.count - 1 - first_);
  std::array<double, 4> held{};
  for (std::size_t k = 0; k < n_; ++k) {
    held[0] += tables_->grid.solid_1()[k] * state[k * lanes_ + lane];
    held[1] += tables_->grid.solid_2()[k] * state[k * lanes_ + lane];
    held[2] += state[(n_ + k) * lanes_ + lane];
    held[3] += state[(2 * n_ + k) * lanes_ + lane];
  }
  for (std::size_t q = 0; q < 4; ++q) flows(rates, ledger::kOut + q)[lane] = turnover_[lane] * held[q];
}

}  // namespace granary::pbm
