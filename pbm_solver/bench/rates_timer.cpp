#include "pbm_solver/bench/rates_timer.hpp"

#include <algorithm>

namespace granary::pbm::bench {

SolverRates::SolverRates(const PbmCase& c, const Snapshot& at, Exchange& exchange, int threads)
    : tables_(std::make_unique<ModelTables>(c)),
      row_(*tables_, exchange, threads),
      inputs_(inputs_at(c, at.time)),
      state_(row_.size()),
      rates_(row_.size()) {
  const std::size_t n = row_.classes(), first = static_cast<std::size_t>(exchange.share().first);
  for (std::size_t x = 0; x < row_.compartments(); ++x) {
    double* to = &state_[x * row_.stride()];
    for (const auto* field : {&at.number, &at.liquid, &at.gas})
      to = std::copy_n(field->begin() + static_cast<std::ptrdiff_t>((first + x) * n), n, to);
  }
}

void SolverRates::evaluate() { row_.rates(state_, {}, inputs_, rates_); }

ReferenceState SolverRates::rates() const {
  ReferenceState all;
  for (std::size_t x = 0; x < row_.compartments(); ++x) {
    const Fields f = row_.fields(rates_, x);
    all.number.insert(all.number.end(), f.number.begin(), f.number.end());
    all.liquid.insert(all.liquid.end(), f.liquid.begin(), f.liquid.end());
    all.gas.insert(all.gas.end(), f.gas.begin(), f.gas.end());
  }
  return all;
}

}  // namespace granary::pbm::bench
