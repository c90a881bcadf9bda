#include "pbm_solver/time/snapshot.hpp"

#include <array>
#include <cmath>

#include "pbm_solver/model/model_tables.hpp"

namespace granary::pbm {

Snapshot initial_snapshot(const PbmCase& c, const ClassGrid& grid) {
  const std::size_t n = grid.size(), n_compartments = static_cast<std::size_t>(c.compartments.count);
  Snapshot s;
  s.time = c.start_time;
  for (auto* list : {&s.number, &s.liquid, &s.gas}) list->assign(n_compartments * n, 0.0);
  s.ledger.assign(n_compartments * ledger::kSize, 0.0);
  for (const InitialClass& one : c.initial)
    for (std::size_t x = 0; x < n_compartments; ++x) {
      if (one.compartment >= 0 && static_cast<std::size_t>(one.compartment) != x) continue;
      const std::size_t k = x * n + grid.index(one.i, one.j);
      s.number[k] += one.number;
      s.liquid[k] += one.liquid;
      s.gas[k] += one.gas;
    }
  for (std::size_t x = 0; x < n_compartments; ++x) {
    const auto part = [&](const std::vector<double>& all) { return std::span(all).subspan(x * n, n); };
    const std::array<double, 4> held = holdup(grid, {part(s.number), part(s.liquid), part(s.gas)});
    for (std::size_t q = 0; q < 4; ++q) s.ledger[x * ledger::kSize + ledger::kStart + q] = held[q];
  }
  return s;
}

Drift drift(const Snapshot& s, const ClassGrid& grid) {
  const std::size_t n = grid.size();
  std::array<double, 4> balance{}, ever{};
  for (std::size_t x = 0; x * ledger::kSize < s.ledger.size(); ++x) {
    const auto part = [&](const std::vector<double>& all) { return std::span(all).subspan(x * n, n); };
    const std::array<double, 4> held = holdup(grid, {part(s.number), part(s.liquid), part(s.gas)});
    const double* book = &s.ledger[x * ledger::kSize];
    for (std::size_t q = 0; q < 4; ++q) {
      const double came = book[ledger::kStart + q] + book[ledger::kIn + q];
      balance[q] += held[q] - came + book[ledger::kOut + q] + book[ledger::kOversize + q];
      ever[q] += came;
    }
    balance[3] += book[ledger::kConsolidated];
  }
  const auto relative = [&](std::size_t q) { return ever[q] > 0.0 ? std::abs(balance[q]) / ever[q] : 0.0; };
  return {relative(0), relative(1), relative(2), relative(3)};
}

}  // namespace granary::pbm
