#include "pbm_solver/model/compartment.hpp"

#include <algorithm>
#include <cmath>

#include "pbm_solver/model/consolidation.hpp"

namespace granary::pbm {

std::array<double, 4> holdup(const ClassGrid& grid, Fields state) {
  std::array<double, 4> sum{};
  for (std::size_t k = 0; k < grid.size(); ++k) {
    sum[0] += grid.solid_1()[k] * state.number[k];
    sum[1] += grid.solid_2()[k] * state.number[k];
    sum[2] += state.liquid[k];
    sum[3] += state.gas[k];
  }
  return sum;
}

Inputs inputs_at(const PbmCase& c, double time) {
  return {c.feed && time >= c.feed->start && time < c.feed->end,
          c.spray && time >= c.spray->start && time < c.spray->end};
}

ModelTables::ModelTables(const PbmCase& c) : pbm_case(c), grid(c.grid) {
  if (c.breakage) daughters.emplace(grid, c.breakage->daughters);
  if (c.aggregation && c.aggregation->kernel == Aggregation::Kernel::dem)
    for (const double d : c.dem->diameter) ln_dem_diameter.push_back(std::log(d));
}

Compartment::Compartment(const ModelTables& tables, int index)
    : tables_(&tables), index_(index), births_(tables.grid), loss_rate_(tables.grid.size()) {
  const PbmCase& c = tables.pbm_case;
  if (c.aggregation) {
    kernel_.emplace(c, index);
    aggregation_.emplace(tables.grid);
  }
  if (c.breakage) {
    selection_.emplace(c, index);
    for (auto* list : {&broken_.number, &broken_.liquid, &broken_.gas}) list->resize(tables.grid.size());
  }
}

void Compartment::prepare(Fields state, std::span<const double> participation) {
  if (aggregation_ || selection_)
    classes_.assign(tables_->grid, tables_->pbm_case.materials, state, participation, tables_->ln_dem_diameter);
}

void Compartment::finish(Fields state, Fields upstream, Inputs inputs, FieldRates rates, std::span<double> flows) {
  for (auto span : {rates.number, rates.liquid, rates.gas, flows, std::span(loss_rate_)})
    std::fill(span.begin(), span.end(), 0.0);
  if (aggregation_ || selection_) add_kinetics(rates, flows);
  if (tables_->pbm_case.consolidation) consolidate(state, rates, flows);
  if (inputs.feed && index_ == 0) add_feed(rates, flows);
  if (inputs.spray && tables_->pbm_case.spray->compartment == index_) add_spray(state, rates, flows);
  if (tables_->pbm_case.compartments.residence_time) add_flow(state, upstream, rates, flows);
}

/// Births of aggregation and breakage share one cell average; what both take away is lost per particle.
void Compartment::add_kinetics(FieldRates rates, std::span<double> flows) {
  births_.clear();
  death_.assign(classes_.size(), 0.0);
  if (aggregation_) aggregation_->collect(classes_, births_, death_);
  if (selection_) add_breakage();
  share_births(tables_->grid, births_, rates);
  for (std::size_t p = 0; p < classes_.size(); ++p) {
    const auto k = static_cast<std::size_t>(classes_.index[p]);
    rates.number[k] -= death_[p] * classes_.number[p];
    rates.liquid[k] -= death_[p] * classes_.liquid[p];
    rates.gas[k] -= death_[p] * classes_.gas[p];
    loss_rate_[k] = death_[p];
  }
  const Birth above = births_.oversize();
  flows[ledger::kOversize] = above.solid_1;
  flows[ledger::kOversize + 1] = above.solid_2;
  flows[ledger::kOversize + 2] = above.liquid;
  flows[ledger::kOversize + 3] = above.gas;
  flows[ledger::kOversizeNumber] = above.number;
}

void Compartment::add_breakage() {
  for (auto* list : {&broken_.number, &broken_.liquid, &broken_.gas}) std::fill(list->begin(), list->end(), 0.0);
  for (std::size_t p = 0; p < classes_.size(); ++p) {
    const auto k = static_cast<std::size_t>(classes_.index[p]);
    if (!tables_->daughters->divisible(k)) continue;
    const double rate = (*selection_)(classes_, p);
    death_[p] += rate;
    broken_.number[k] = rate * classes_.number[p];
    broken_.liquid[k] = rate * classes_.liquid[p];
    broken_.gas[k] = rate * classes_.gas[p];
  }
  tables_->daughters->add_births(tables_->grid, broken_, births_);
}

void Compartment::consolidate(Fields state, FieldRates rates, std::span<double> flows) const {
  const PbmCase& c = tables_->pbm_case;
  for (std::size_t k = 0; k < tables_->grid.size(); ++k) {
    if (!(state.number[k] > 0.0)) continue;
    const double l = state.liquid[k] / state.number[k], g = state.gas[k] / state.number[k];
    const double lost = state.number[k] * consolidation_rate(*c.consolidation, c.materials.saturation_factor,
                                                             tables_->grid.solid()[k], l, g);
    rates.gas[k] -= lost;
    flows[ledger::kConsolidated] += lost;
  }
}

/// Fed particles: dry, with gas = solid porosity / (1 - porosity).
void Compartment::add_feed(FieldRates rates, std::span<double> flows) const {
  const Feed& feed = *tables_->pbm_case.feed;
  const double gas_per_solid = feed.porosity / (1.0 - feed.porosity);
  for (const ClassRate& c : feed.classes) {
    const std::size_t k = tables_->grid.index(c.i, c.j);
    const double gas = c.rate * tables_->grid.solid()[k] * gas_per_solid;
    rates.number[k] += c.rate;
    rates.gas[k] += gas;
    flows[ledger::kIn] += c.rate * tables_->grid.solid_1()[k];
    flows[ledger::kIn + 1] += c.rate * tables_->grid.solid_2()[k];
    flows[ledger::kIn + 3] += gas;
  }
}

/// Each particle takes liquid in proportion to its solid volume. An empty compartment takes none.
void Compartment::add_spray(Fields state, FieldRates rates, std::span<double> flows) const {
  const ClassGrid& grid = tables_->grid;
  double solid = 0.0;
  for (std::size_t k = 0; k < grid.size(); ++k) solid += grid.solid()[k] * state.number[k];
  if (!(solid > 0.0)) return;
  const double rate = tables_->pbm_case.spray->rate;
  for (std::size_t k = 0; k < grid.size(); ++k) rates.liquid[k] += rate * (grid.solid()[k] * state.number[k] / solid);
  flows[ledger::kIn + 2] += rate;
}

/// Out of each compartment and into the next at k = count / residence time [1/s] of its content.
void Compartment::add_flow(Fields state, Fields upstream, FieldRates rates, std::span<double> flows) const {
  const Compartments& row = tables_->pbm_case.compartments;
  const double turnover = row.count / *row.residence_time;
  for (std::size_t k = 0; k < tables_->grid.size(); ++k) {
    rates.number[k] -= turnover * state.number[k];
    rates.liquid[k] -= turnover * state.liquid[k];
    rates.gas[k] -= turnover * state.gas[k];
  }
  if (!upstream.number.empty())
    for (std::size_t k = 0; k < tables_->grid.size(); ++k) {
      rates.number[k] += turnover * upstream.number[k];
      rates.liquid[k] += turnover * upstream.liquid[k];
      rates.gas[k] += turnover * upstream.gas[k];
    }
  if (index_ + 1 < row.count) return;
  const std::array<double, 4> held = holdup(tables_->grid, state);
  for (std::size_t q = 0; q < 4; ++q) flows[ledger::kOut + q] = turnover * held[q];
}

}  // namespace granary::pbm
