#include "pbm_solver/time/compartment_row.hpp"

namespace granary::pbm {
namespace {

Fields fields_at(const double* first, std::size_t n) {
  return {std::span(first, n), std::span(first + n, n), std::span(first + 2 * n, n)};
}

}  // namespace

CompartmentRow::CompartmentRow(const ModelTables& tables, Exchange& exchange, int threads)
    : tables_(&tables), exchange_(&exchange), threads_(threads), n_(tables.grid.size()) {
  const Share share = exchange.share();
  for (int x = 0; x < share.count; ++x) compartments_.emplace_back(tables, share.first + x);
  if (share.first > 0) upstream_.resize(3 * n_);
}

Fields CompartmentRow::fields(std::span<const double> state, std::size_t x) const {
  return fields_at(state.data() + x * stride(), n_);
}

void CompartmentRow::rates(std::span<const double> state, std::span<const double> participation, Inputs inputs,
                           std::span<double> rates) {
  if (tables_->pbm_case.compartments.residence_time)
    exchange_->pass_downstream(state.subspan((compartments() - 1) * stride(), 3 * n_), upstream_);
  const int n_compartments = static_cast<int>(compartments());
  const int parts = compartments_.front().parts();
  // Whole compartments where they share out well: the threads then meet once instead of three times.
  if (parts == 0 || threads_ == 1 || n_compartments % threads_ == 0 || n_compartments >= 4 * threads_) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads_) if (threads_ > 1)
    for (int x = 0; x < n_compartments; ++x) {
      prepare(state, participation, x);
      for (int part = 0; part < parts; ++part) compartments_[static_cast<std::size_t>(x)].run_part(part);
      finish(state, inputs, x, rates);
    }
    return;
  }
#pragma omp parallel num_threads(threads_)
  {
#pragma omp for schedule(static)
    for (int x = 0; x < n_compartments; ++x) prepare(state, participation, x);
#pragma omp for schedule(dynamic, 1)
    for (int task = 0; task < n_compartments * parts; ++task)
      compartments_[static_cast<std::size_t>(task / parts)].run_part(task % parts);
#pragma omp for schedule(static)
    for (int x = 0; x < n_compartments; ++x) finish(state, inputs, x, rates);
  }
}

void CompartmentRow::prepare(std::span<const double> state, std::span<const double> participation, int x) {
  const auto at = static_cast<std::size_t>(x);
  compartments_[at].prepare(fields(state, at),
                            participation.empty() ? participation : participation.subspan(at * n_, n_));
}

void CompartmentRow::finish(std::span<const double> state, Inputs inputs, int x, std::span<double> rates) {
  const auto at = static_cast<std::size_t>(x);
  const Fields above = x > 0 ? fields(state, at - 1) : upstream_.empty() ? Fields{} : fields_at(upstream_.data(), n_);
  double* out = rates.data() + at * stride();
  compartments_[at].finish(fields(state, at), above, inputs,
                           {std::span(out, n_), std::span(out + n_, n_), std::span(out + 2 * n_, n_)},
                           std::span(out + 3 * n_, ledger::kSize));
}

}  // namespace granary::pbm
