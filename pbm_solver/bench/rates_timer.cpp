#include "pbm_solver/bench/rates_timer.hpp"

#include <algorithm>

namespace granary::pbm::bench {

SolverRates::SolverRates(const PbmCase& c, const Snapshot& at, Exchange& exchange, int threads)
    : tables_(std::make_unique<ModelTables>(c)),
      row_(*tables_, exchange, threads),
      inputs_(inputs_at(c, at.time)),
      state_(row_.size()),
      rates_(row_.size()) {
  const auto n = static_cast<std::ptrdiff_t>(row_.classes());
  std::vector<double> one(static_cast<std::size_t>(3 * n) + ledger::kSize);
  for (std::size_t x = 0; x < row_.compartments(); ++x) {
    const auto from = (exchange.share().first + static_cast<std::ptrdiff_t>(x)) * n;
    auto to = one.begin();
    for (const auto* field : {&at.number, &at.liquid, &at.gas}) to = std::copy_n(field->begin() + from, n, to);
    row_.pack(one, x, state_);
  }
  refresh();
}

void SolverRates::refresh() { row_.begin_step(state_, true); }

void SolverRates::evaluate() { row_.rates(state_, {}, inputs_, rates_); }

ReferenceState SolverRates::rates() const {
  ReferenceState all;
  const auto n = static_cast<std::ptrdiff_t>(row_.classes());
  std::vector<double> one(static_cast<std::size_t>(3 * n) + ledger::kSize);
  for (std::size_t x = 0; x < row_.compartments(); ++x) {
    row_.unpack(rates_, x, one);
    auto from = one.begin();
    for (auto* field : {&all.number, &all.liquid, &all.gas}) {
      field->insert(field->end(), from, from + n);
      from += n;
    }
  }
  return all;
}

}  // namespace granary::pbm::bench
