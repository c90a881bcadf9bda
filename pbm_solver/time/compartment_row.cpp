#include "pbm_solver/time/compartment_row.hpp"

#include <algorithm>

namespace granary::pbm {

CompartmentRow::CompartmentRow(const ModelTables& tables, Exchange& exchange, int threads)
    : tables_(&tables),
      exchange_(&exchange),
      threads_(threads),
      compartments_(static_cast<std::size_t>(exchange.share().count)),
      n_(tables.grid.size()),
      lanes_(static_cast<std::size_t>(tables.lanes)) {
  const Share share = exchange.share();
  for (int x = 0; x < share.count; x += tables.lanes)
    blocks_.emplace_back(tables, share.first + x, std::min(tables.lanes, share.count - x));
  if (!tables.pbm_case.compartments.residence_time) return;
  if (share.first > 0) upstream_.resize(3 * n_);
  last_.resize(3 * n_);
  carry_.assign(blocks_.size(), std::vector<double>(3 * n_));
}

void CompartmentRow::unpack(std::span<const double> state, std::size_t x, std::span<double> compartment) const {
  const double* from = &state[at(x, 0)];
  for (std::size_t e = 0; e < compartment.size(); ++e) compartment[e] = from[e * lanes_];
}

void CompartmentRow::pack(std::span<const double> compartment, std::size_t x, std::span<double> state) const {
  double* to = &state[at(x, 0)];
  for (std::size_t e = 0; e < compartment.size(); ++e) to[e * lanes_] = compartment[e];
}

double CompartmentRow::kernel_error() const {
  double largest = 0.0;
  for (const CompartmentBlock& block : blocks_)
    if (block.aggregation() != nullptr) largest = std::max(largest, block.aggregation()->kernel_error());
  return largest;
}

void CompartmentRow::for_each_block(const std::function<void(std::size_t)>& each) const {
  const int n = static_cast<int>(blocks_.size());
#pragma omp parallel for schedule(static, 1) num_threads(std::min(threads_, n)) if (threads_ > 1 && n > 1)
  for (int b = 0; b < n; ++b) each(static_cast<std::size_t>(b));
}

void CompartmentRow::begin_step(std::span<const double> state, bool afresh) {
  follow_particles(state, afresh);
  for_each_block([&](std::size_t b) { blocks_[b].begin_step(&state[b * stride()]); });
}

/// All compartments look at their particles when those of one have moved: how they are shared among blocks and ranks
/// must not show.
void CompartmentRow::follow_particles(std::span<const double> state, bool afresh) {
  if (!blocks_.front().looks_at_particles()) return;
  if (!afresh) {
    std::vector<double> mine(compartments_, 0.0);
    std::vector<double> all(static_cast<std::size_t>(tables_->pbm_case.compartments.count), 0.0);
    for (std::size_t b = 0; b < blocks(); ++b)
      if (blocks_[b].moved(&state[b * stride()])) mine[b * lanes_] = 1.0;
    exchange_->gather(mine, all);
    if (std::find(all.begin(), all.end(), 1.0) == all.end()) return;
  }
  for_each_block([&](std::size_t b) { blocks_[b].look_at_particles(&state[b * stride()]); });
}

/// The last compartment of the block before flows into the first lane.
void CompartmentRow::read_carry(std::span<const double> state, std::size_t b) {
  if (b == 0) {
    if (!upstream_.empty()) carry_[0] = upstream_;
    return;
  }
  unpack(state, b * lanes_ - 1, carry_[b]);
}

void CompartmentRow::rates(std::span<const double> state, std::span<const double> participation, Inputs inputs,
                           std::span<double> rates, bool breakage) {
  follow_particles(state, false);
  const bool flow = !last_.empty();
  if (flow) {
    unpack(state, compartments_ - 1, last_);
    exchange_->pass_downstream(last_, upstream_);
  }
  for_each_block([&](std::size_t b) {
    const bool carried = flow && (b > 0 || !upstream_.empty());
    if (carried) read_carry(state, b);
    blocks_[b].rates(&state[b * stride()], participation.empty() ? nullptr : &participation[b * n_ * lanes_],
                     carried ? carry_[b].data() : nullptr, inputs, breakage, &rates[b * stride()]);
  });
}

void CompartmentRow::add_breakage(double factor, std::span<const double> state, std::span<double> out) {
  for_each_block([&](std::size_t b) { blocks_[b].add_breakage(factor, &state[b * stride()], &out[b * stride()]); });
}

void CompartmentRow::solve_breakage(double gamma, std::span<double> state) {
  for_each_block([&](std::size_t b) { blocks_[b].solve_breakage(gamma, &state[b * stride()]); });
}

}  // namespace granary::pbm
