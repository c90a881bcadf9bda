#include "pbm_solver/time/small_classes.hpp"

#include <algorithm>
#include <cmath>

namespace granary::pbm {
namespace {

constexpr double kMargin = 0.9;  // of the longest step that keeps a class positive
constexpr double kSmall = 0.1;   // of the tolerance: share of a compartment's solids in all small classes together
constexpr double kDust = 1e-12;  // share of a compartment's solids
constexpr int kOctaves = 64;     // below a compartment's solids: classes that hold less are counted together

}  // namespace

SmallClasses::SmallClasses(const CompartmentRow& row, double tolerance)
    : row_(&row),
      tolerance_(tolerance),
      sizes_(row.class_values()),
      all_loss_(row.class_values()),
      loss_(row.class_values()) {}

void SmallClasses::begin_step(std::span<const double> state, std::span<const Held> held) {
  state_ = state, held_ = held;
  marked_ = false;
  participation_.clear();
}

void SmallClasses::set_losses(std::span<const double> implicit_rate) {
  const std::size_t each = row_->classes() * row_->lanes();
  std::array<double, kLanes> largest{};
  for (std::size_t b = 0; b < row_->blocks(); ++b) {
    const double* all = row_->loss_rate(b).data();
    double* loss = &loss_[b * each];
    std::copy_n(all, each, &all_loss_[b * each]);
    if (implicit_rate.empty()) {
      std::copy_n(all, each, loss);
    } else {
      const double* implicit = &implicit_rate[b * each];
      for (std::size_t at = 0; at < each; ++at) loss[at] = std::max(0.0, all[at] - implicit[at]);
    }
  }
  std::size_t at = 0;
  for (; at + kLanes <= loss_.size(); at += kLanes)
    for (std::size_t l = 0; l < kLanes; ++l) largest[l] = std::max(largest[l], loss_[at + l]);
  for (; at < loss_.size(); ++at) largest[0] = std::max(largest[0], loss_[at]);
  fastest_ = *std::max_element(largest.begin(), largest.end());
}

bool SmallClasses::is_fast(double h, double loss_rate) { return 0.5 * h * loss_rate > kMargin; }

/// The classes that hold least, together at most kSmall of what the tolerance allows; among them the dust. What they
/// hold is sorted by octaves only.
void SmallClasses::mark_sizes(std::size_t x) {
  const std::size_t n = row_->classes(), lanes = row_->lanes();
  const double* number = &state_[row_->at(x, 0)];
  const std::span<const double> solid = row_->grid().solid();
  const double total = held_[x][1];
  Size* sizes = &sizes_[row_->by_class(x, 0)];
  std::array<double, kOctaves> in_octave{};
  const auto octave = [&](double held) {
    return held > 0.0 ? std::clamp(std::ilogb(total) - std::ilogb(held), 0, kOctaves - 1) : kOctaves - 1;
  };
  for (std::size_t k = 0; k < n; ++k) {
    const double held = std::abs(solid[k] * number[k * lanes]);
    in_octave[static_cast<std::size_t>(octave(held))] += held;
  }
  int smallest_large = kOctaves - 1;
  for (double sum = in_octave.back(); smallest_large >= 0 && sum < kSmall * tolerance_ * total;)
    sum += in_octave[static_cast<std::size_t>(std::max(0, --smallest_large))];
  for (std::size_t k = 0; k < n; ++k) {
    const double held = std::abs(solid[k] * number[k * lanes]);
    sizes[k * lanes] = octave(held) <= smallest_large ? Size::large : held < kDust * total ? Size::dust : Size::small;
  }
}

void SmallClasses::mark_sizes() {
  if (marked_) return;
  for (std::size_t x = 0; x < row_->compartments(); ++x) mark_sizes(x);
  marked_ = true;
}

bool SmallClasses::emptied(std::span<const double> rates, std::size_t x, std::size_t k, double h) const {
  for (std::size_t q = 0; q < 3; ++q) {
    const std::size_t at = row_->at(x, q * row_->classes() + k);
    if (state_[at] > 0.0 && state_[at] + 0.5 * h * rates[at] < 0.0) return true;
  }
  return false;
}

/// Small, faster than the step, and emptied by it. Dust in any case: its births may stop in a later stage.
bool SmallClasses::slowed_down(std::span<const double> rates, std::size_t x, std::size_t k, double h) const {
  const std::size_t at = row_->by_class(x, k);
  if (!is_fast(h, loss_[at]) || sizes_[at] == Size::large) return false;
  return sizes_[at] == Size::dust || emptied(rates, x, k, h);
}

double SmallClasses::limit_by_emptying(std::span<const double> rates, double h) {
  if (!is_fast(h, fastest_)) return h;
  mark_sizes();
  const std::size_t n = row_->classes();
  double limit = h;
  for (std::size_t x = 0; x < row_->compartments(); ++x)
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t class_at = row_->by_class(x, k);
      if (!is_fast(h, loss_[class_at]) || sizes_[class_at] != Size::large) continue;
      for (std::size_t q = 0; q < 3; ++q) {
        const std::size_t at = row_->at(x, q * n + k);
        if (state_[at] > 0.0 && state_[at] + 0.5 * h * rates[at] < 0.0)
          limit = std::min(limit, kMargin * 2.0 * state_[at] / -rates[at]);
      }
    }
  return limit;
}

double SmallClasses::limit_by_filling(std::span<const double> rates, double h) {
  if (!is_fast(h, fastest_)) return h;
  mark_sizes();
  const std::size_t n = row_->classes();
  const std::span<const double> solid = row_->grid().solid();
  double limit = h;
  for (std::size_t x = 0; x < row_->compartments(); ++x) {
    double born = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t class_at = row_->by_class(x, k);
      if (!is_fast(h, loss_[class_at]) || sizes_[class_at] != Size::small || !slowed_down(rates, x, k, h)) continue;
      const std::size_t at = row_->at(x, k);
      born += solid[k] * std::max(0.0, rates[at] + loss_[class_at] * state_[at]);
    }
    if (born > 0.0) limit = std::min(limit, 0.5 * kSmall * tolerance_ * held_[x][1] / born);
  }
  return limit;
}

bool SmallClasses::slow_down(std::span<const double> rates, double h) {
  participation_.clear();
  if (!is_fast(h, fastest_)) return false;
  mark_sizes();
  bool any = false;
  participation_.assign(row_->class_values(), 1.0);
  for (std::size_t x = 0; x < row_->compartments(); ++x)
    for (std::size_t k = 0; k < row_->classes(); ++k) {
      const std::size_t at = row_->by_class(x, k);
      if (!is_fast(h, loss_[at]) || !slowed_down(rates, x, k, h)) continue;
      participation_[at] = kMargin / (0.5 * h * loss_[at]);
      any = true;
    }
  if (!any) participation_.clear();
  return any;
}

void SmallClasses::check(std::span<const double> stage, double h, bool tolerant, std::span<Negative> accounts) {
  for (std::size_t b = 0; b < row_->blocks(); ++b)
    if (any_negative(*row_, stage, b)) check_block(b, stage, h, tolerant, accounts);
}

void SmallClasses::check_block(std::size_t b, std::span<const double> stage, double h, bool tolerant,
                               std::span<Negative> accounts) {
  mark_sizes();
  const std::size_t n = row_->classes();
  const std::span<const double> solid = row_->grid().solid();
  for (std::size_t x = b * row_->lanes(); x < std::min((b + 1) * row_->lanes(), row_->compartments()); ++x)
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t q = 0; q < 3; ++q) {
        const double value = stage[row_->at(x, q * n + k)];
        if (!(value < 0.0)) continue;
        const std::size_t at = row_->by_class(x, k);
        const double part = participation_.empty() ? 1.0 : participation_[at];
        if (tolerant && !is_fast(h, part * loss_[at])) {
          accounts[x].amount[q == 0 ? 0 : q + 1] -= value;
          if (q == 0) accounts[x].amount[1] -= solid[k] * value;
        } else if (sizes_[at] == Size::large) {
          accounts[x].shorten = true;
        } else {
          accounts[x].slowed = true;
          if (participation_.empty()) participation_.assign(row_->class_values(), 1.0);
          participation_[at] = std::min(0.5 * participation_[at], kMargin / (0.5 * h * all_loss_[at]));
        }
      }
}

}  // namespace granary::pbm
