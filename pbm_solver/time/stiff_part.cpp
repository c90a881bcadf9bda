#include "pbm_solver/time/stiff_part.hpp"

#include <algorithm>

namespace granary::pbm {
namespace {

constexpr double kStiff = 2.0;  // step times rate: up to it an Euler step of half the step keeps a class positive
// Of the tolerance: shares of what is held that may pass through stiff classes of an explicit step.
constexpr double kNothing = 1e-15;
constexpr double kNegligible = 0.05;

}  // namespace

StiffPart::StiffPart(const CompartmentRow& row, int threads)
    : row_(&row),
      do_(&simd::operations(static_cast<int>(row.lanes()))),
      threads_(std::min(threads, static_cast<int>(row.blocks()))),
      rate_(row.class_values()),
      leaving_rate_(row.class_values()),
      selection_(row.class_values()),
      leaving_(row.class_values()),
      damped_(row.class_values()),
      scratch_(2 * row.class_values()) {
  const ClassGrid& grid = row.grid();
  if (row.tables().aggregation)
    for (int i = 0; i < grid.axis(0).size(); ++i)
      for (int j = 0; j < grid.axis(1).size(); ++j)
        if (grid.axis(0).highest_partner(i) < 0 || grid.axis(1).highest_partner(j) < 0)
          top_.push_back(grid.index(i, j));
  exists_ = row.tables().fragments.has_value() || !top_.empty();
}

void StiffPart::freeze() {
  const std::size_t lanes = row_->lanes(), each = row_->classes() * lanes;
  for (std::size_t b = 0; b < row_->blocks(); ++b) {
    double *rate = &rate_[b * each], *leaving = &leaving_rate_[b * each];
    const std::span<const double> selection = row_->block(b).selection_rate(), loss = row_->loss_rate(b);
    std::copy(selection.begin(), selection.end(), rate);
    for (const std::size_t k : top_)
      for (std::size_t at = k * lanes; at < (k + 1) * lanes; ++at) {
        leaving[at] = std::max(0.0, loss[at] - rate[at]);
        rate[at] += leaving[at];
      }
  }
  slow_down({});
}

void StiffPart::slow_down(std::span<const double> participation) {
  const std::size_t each = row_->classes() * row_->lanes();
  for (std::size_t b = 0; b < row_->blocks(); ++b) {
    const std::span<const double> selection = row_->block(b).selection_rate();
    std::copy(selection.begin(), selection.end(), selection_.begin() + static_cast<std::ptrdiff_t>(b * each));
  }
  leaving_ = leaving_rate_;
  for (std::size_t at = 0; at < participation.size(); ++at) {
    selection_[at] *= participation[at];
    leaving_[at] *= participation[at];
  }
}

bool StiffPart::needed(std::span<const double> state, std::span<const double> rates, double h,
                       std::span<const Held> held, double tolerance) const {
  const std::size_t lanes = row_->lanes();
  const std::span<const double> solid = row_->grid().solid();
  for (std::size_t x = 0; x < row_->compartments(); ++x) {
    const double* loss = row_->loss_rate(x / lanes).data() + x % lanes;
    double breaks = 0.0, leaves = 0.0;
    for (std::size_t k = 0; k < row_->classes(); ++k) {
      const std::size_t at = row_->by_class(x, k);
      if (!(h * rate_[at] > kStiff)) continue;
      const double number = state[row_->at(x, k)], born = rates[row_->at(x, k)] + loss[k * lanes] * number;
      (h * selection_[at] > kStiff ? breaks : leaves) += solid[k] * h * std::max({0.0, born, rate_[at] * number});
    }
    if (breaks > kNothing * tolerance * held[x][1] || leaves > kNegligible * tolerance * held[x][1]) return true;
  }
  return false;
}

/// out -= factor R y, and the same to the ledger. A pair counts as one particle above the grid: its partner's half is
/// in the explicit part.
void StiffPart::leave(std::size_t b, double factor, const double* y, double* out, double* ledger) const {
  const std::size_t lanes = row_->lanes(), each = row_->classes() * lanes;
  const ClassGrid& grid = row_->grid();
  const double* leaving = &leaving_[b * each];
  double* oversize = ledger + ledger::kOversize * lanes;
  for (const std::size_t k : top_)
    for (std::size_t l = 0; l < lanes; ++l) {
      const std::size_t at = k * lanes + l;
      const double share = factor * leaving[at], number = share * y[at];
      if (out != nullptr)
        for (std::size_t q = 0; q < 3; ++q) out[q * each + at] -= share * y[q * each + at];
      ledger[ledger::kOversizeNumber * lanes + l] += number;
      oversize[l] += number * grid.solid_1()[k];
      oversize[lanes + l] += number * grid.solid_2()[k];
      oversize[2 * lanes + l] += share * y[each + at];
      oversize[3 * lanes + l] += share * y[2 * each + at];
    }
}

void StiffPart::add(double factor, std::span<const double> y, std::span<double> out, bool breakage) const {
  const std::size_t each = row_->classes() * row_->lanes();
  const int n_blocks = static_cast<int>(row_->blocks());
#pragma omp parallel for schedule(static, 1) num_threads(threads_) if (threads_ > 1)
  for (int one = 0; one < n_blocks; ++one) {
    const simd::FlushDenormals flush;
    const auto b = static_cast<std::size_t>(one);
    const double* from = &y[b * row_->stride()];
    double* to = &out[b * row_->stride()];
    leave(b, factor, from, to, to + 3 * each);
    if (!breakage || !row_->tables().fragments) continue;
    for (std::size_t q = 0; q < 3; ++q)
      do_->add_breakage(row_->tables().view, row_->tables().fragments->view(), &selection_[b * each],
                        q == 0 ? nullptr : row_->grid().solid().data(), factor, from + q * each,
                        &scratch_[2 * b * each], to + q * each);
  }
}

/// With A = M S (S: selection rates) and D = 1 + gamma R: (D - gamma M S) y = r is (1 - gamma M S/D) D y = r.
void StiffPart::solve(double gamma, std::span<double> y) const {
  const std::size_t lanes = row_->lanes(), each = row_->classes() * lanes;
  const int n_blocks = static_cast<int>(row_->blocks());
#pragma omp parallel for schedule(static, 1) num_threads(threads_) if (threads_ > 1)
  for (int one = 0; one < n_blocks; ++one) {
    const simd::FlushDenormals flush;
    const auto b = static_cast<std::size_t>(one);
    double* state = &y[b * row_->stride()];
    const double* leaving = &leaving_[b * each];
    if (row_->tables().fragments) {
      double* damped = &damped_[b * each];
      std::copy_n(&selection_[b * each], each, damped);
      for (const std::size_t k : top_)
        for (std::size_t at = k * lanes; at < (k + 1) * lanes; ++at) damped[at] /= 1.0 + gamma * leaving[at];
      for (std::size_t q = 0; q < 3; ++q)
        do_->solve_breakage(row_->tables().view, row_->tables().fragments->view(), damped,
                            q == 0 ? nullptr : row_->grid().solid().data(), gamma, &scratch_[2 * b * each],
                            state + q * each);
    }
    for (const std::size_t k : top_)
      for (std::size_t at = k * lanes; at < (k + 1) * lanes; ++at)
        for (std::size_t q = 0; q < 3; ++q) state[q * each + at] /= 1.0 + gamma * leaving[at];
    leave(b, gamma, state, nullptr, state + 3 * each);
  }
}

}  // namespace granary::pbm
