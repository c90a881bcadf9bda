#include "pbm_solver/bench/reference_solver.hpp"

#include <algorithm>
#include <cmath>

#include "pbm_solver/bench/class_table.hpp"
#include "pbm_solver/bench/measure.hpp"

namespace granary::pbm::bench {
namespace {

constexpr double kOnEdge = 1e-12;  // a sum within round-off of an edge counts as on it, as in our grid

/// Upper edges of the cells, set back by round-off; the last one is the last pivot, which is inside.
std::vector<double> upper_edges(const SolidAxis& axis) {
  std::vector<double> edges;
  for (int i = 1; i < axis.size(); ++i) edges.push_back(axis.lower_edge(i) * (1.0 - kOnEdge));
  edges.push_back(axis.pivot(axis.size() - 1) * (1.0 + kOnEdge));
  return edges;
}

std::size_t scan(const std::vector<double>& edges, double v) {
  std::size_t cell = 0;
  while (cell < edges.size() && v >= edges[cell]) ++cell;
  return cell;
}

std::size_t bisection(const std::vector<double>& edges, double v) {
  return static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), v) - edges.begin());
}

/// Fastest loss of any content of any class, per content [1/s].
double fastest_loss(const ReferenceState& state, const ReferenceState& rates) {
  double fastest = 0.0;
  const auto look = [&fastest](const std::vector<double>& held, const std::vector<double>& rate) {
    for (std::size_t k = 0; k < held.size(); ++k)
      if (held[k] > 0.0) fastest = std::max(fastest, -rate[k] / held[k]);
  };
  look(state.number, rates.number);
  look(state.liquid, rates.liquid);
  look(state.gas, rates.gas);
  return fastest;
}

void add(std::vector<double>& to, double factor, const std::vector<double>& what) {
  for (std::size_t k = 0; k < to.size(); ++k) to[k] += factor * what[k];
}

}  // namespace

ReferenceSolver::ReferenceSolver(const PbmCase& c, CellSearch search)
    : search_(search),
      grid_(c.grid),
      rows_(static_cast<std::size_t>(grid_.axis(0).size())),
      columns_(static_cast<std::size_t>(grid_.axis(1).size())),
      row_edges_(upper_edges(grid_.axis(0))),
      column_edges_(upper_edges(grid_.axis(1))),
      cells_((rows_ + 1) * (columns_ + 1)) {
  const ClassTable table = class_table_of(c, grid_);
  class_of_ = table.class_of;
  table_ = table.rate;
  n_kernel_classes_ = table.size;
  scale_ = table.scale;
}

void ReferenceSolver::rates(const ReferenceState& state, ReferenceState& rates) {
  for (std::size_t x = 0; x < compartments(); ++x) rates_of_compartment(x, state, rates);
}

void ReferenceSolver::rates_of_compartment(std::size_t x, const ReferenceState& state, ReferenceState& rates) {
  std::fill(cells_.begin(), cells_.end(), Cell{});
  // Lambdas, so that the search is compiled into the loop.
  if (search_ == CellSearch::scan)
    collect_pairs(x, state, rates, [](const auto& edges, double v) { return scan(edges, v); });
  else
    collect_pairs(x, state, rates, [](const auto& edges, double v) { return bisection(edges, v); });
  share_cells(x, rates);
}

template <class Search>
void ReferenceSolver::collect_pairs(std::size_t x, const ReferenceState& state, ReferenceState& rates, Search cell_of) {
  const std::size_t n = grid_.size(), first = x * n;
  const double *number = &state.number[first], *liquid = &state.liquid[first], *gas = &state.gas[first];
  const double *solid_1 = grid_.solid_1().data(), *solid_2 = grid_.solid_2().data();
  const double scale = scale_[x];
  for (std::size_t k = 0; k < n; ++k) {
    const double* beta_of_class = &table_[class_of_[k] * n_kernel_classes_];
    double death = 0.0;
    for (std::size_t m = 0; m < n; ++m) {
      const double beta = scale * beta_of_class[class_of_[m]];
      const double sum_1 = solid_1[k] + solid_1[m], sum_2 = solid_2[k] + solid_2[m];
      const std::size_t row = cell_of(row_edges_, sum_1), column = cell_of(column_edges_, sum_2);
      const double born = 0.5 * beta * number[k] * number[m];
      Cell& cell = cells_[row * (columns_ + 1) + column];
      cell.number += born;
      cell.solid_1 += born * sum_1;
      cell.solid_2 += born * sum_2;
      cell.liquid += 0.5 * beta * (liquid[k] * number[m] + number[k] * liquid[m]);
      cell.gas += 0.5 * beta * (gas[k] * number[m] + number[k] * gas[m]);
      death += beta * number[m];
    }
    rates.number[first + k] = -death * number[k];
    rates.liquid[first + k] = -death * liquid[k];
    rates.gas[first + k] = -death * gas[k];
  }
}

void ReferenceSolver::share_cells(std::size_t x, ReferenceState& rates) const {
  const auto pivot_below = [](const SolidAxis& axis, std::size_t cell, double mean) {
    const bool upper_side = mean >= axis.pivot(static_cast<int>(cell));
    const std::size_t lower = upper_side ? cell : cell - 1;
    return std::min(lower, static_cast<std::size_t>(axis.size()) - 2);
  };
  for (std::size_t i = 0; i < rows_; ++i)
    for (std::size_t j = 0; j < columns_; ++j) {
      const Cell& cell = cells_[i * (columns_ + 1) + j];
      if (cell.number == 0.0) continue;
      const double mean_1 = cell.solid_1 / cell.number, mean_2 = cell.solid_2 / cell.number;
      const std::size_t low_1 = pivot_below(grid_.axis(0), i, mean_1), low_2 = pivot_below(grid_.axis(1), j, mean_2);
      const auto upper_share = [](const SolidAxis& axis, std::size_t low, double mean) {
        const double below = axis.pivot(static_cast<int>(low)), above = axis.pivot(static_cast<int>(low) + 1);
        return (mean - below) / (above - below);
      };
      const double up_1 = upper_share(grid_.axis(0), low_1, mean_1), up_2 = upper_share(grid_.axis(1), low_2, mean_2);
      for (std::size_t a = 0; a < 2; ++a)
        for (std::size_t b = 0; b < 2; ++b) {
          const double weight = (a == 0 ? 1.0 - up_1 : up_1) * (b == 0 ? 1.0 - up_2 : up_2);
          const std::size_t k = (low_1 + a) * columns_ + low_2 + b, at = x * grid_.size() + k;
          const double solid_weight = weight * grid_.solid()[k] / (mean_1 + mean_2);
          rates.number[at] += weight * cell.number;
          rates.liquid[at] += solid_weight * cell.liquid;
          rates.gas[at] += solid_weight * cell.gas;
        }
    }
}

ReferenceState reference_state(const Snapshot& s) { return {s.number, s.liquid, s.gas}; }

EulerRun run_euler(ReferenceSolver& solver, ReferenceState& state, double end, double limit, double most_cpu) {
  EulerRun run;
  ReferenceState rates = state;
  const double began = thread_cpu();
  double time = 0.0, dt = end / 16.0;
  while (time < end && run.cpu < most_cpu) {
    solver.rates(state, rates);
    const double fastest = fastest_loss(state, rates);
    while (fastest * dt < limit && dt < end) dt *= 2.0;
    while (fastest * dt > limit) dt *= 0.5;
    const bool last = dt >= end - time;
    const double step = last ? end - time : dt;
    add(state.number, step, rates.number);
    add(state.liquid, step, rates.liquid);
    add(state.gas, step, rates.gas);
    time = last ? end : time + step;
    ++run.steps;
    run.cpu = thread_cpu() - began;
  }
  run.finished = time >= end;
  return run;
}

}  // namespace granary::pbm::bench
