#include "pbm_solver/time/small_classes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace granary::pbm {
namespace {

constexpr double kMargin = 0.9;   // of the longest step that keeps a class positive
constexpr double kCaution = 2.0;  // classes slowed down may become faster in later stages by this factor
constexpr double kSmall = 0.1;    // of the tolerance: share of a compartment's solids in all small classes together
constexpr double kDust = 1e-12;   // share of a compartment's solids
constexpr int kOctaves = 64;      // below a compartment's solids: classes that hold less are counted together

/// Of a number >= 0, from its bits; a large negative one of 0.
int exponent(double value) { return static_cast<int>(std::bit_cast<std::uint64_t>(value) >> 52U); }

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
  caution_ = implicit_rate.empty() ? kCaution : 1.0;
  std::vector<double> fastest(row_->blocks(), 0.0);
  row_->for_each_block([&](std::size_t b) {
    const double* all = row_->loss_rate(b).data();
    double* loss = &loss_[b * each];
    std::copy_n(all, each, &all_loss_[b * each]);
    if (implicit_rate.empty()) {
      std::copy_n(all, each, loss);
    } else {
      const double* implicit = &implicit_rate[b * each];
      for (std::size_t at = 0; at < each; ++at) loss[at] = std::max(0.0, all[at] - implicit[at]);
    }
    std::array<double, kLanes> largest{};
    std::size_t at = 0;
    for (; at + kLanes <= each; at += kLanes)
      for (std::size_t l = 0; l < kLanes; ++l) largest[l] = std::max(largest[l], loss[at + l]);
    for (; at < each; ++at) largest[0] = std::max(largest[0], loss[at]);
    fastest[b] = *std::max_element(largest.begin(), largest.end());
  });
  fastest_ = fastest.empty() ? 0.0 : *std::max_element(fastest.begin(), fastest.end());
}

bool SmallClasses::is_fast(double h, double loss_rate) { return 0.5 * h * loss_rate > kMargin; }

/// The classes that hold least, together at most kSmall of what the tolerance allows; among them the dust. What they
/// hold is sorted by octaves only.
void SmallClasses::mark_sizes() {
  if (marked_) return;
  marked_ = true;
  const std::size_t lanes = row_->lanes(), each = row_->classes() * lanes;
  const double* solid = row_->tables().solids.solid.data();
  std::vector<int> octaves(each);
  for (std::size_t b = 0; b < row_->blocks(); ++b) {
    const double* number = &state_[b * row_->stride()];
    std::array<std::array<double, kOctaves>, kLanes> in_octave{};
    std::array<int, kLanes> top{}, smallest_large{};
    std::array<double, kLanes> total{};
    const std::size_t in_block = std::min(lanes, row_->compartments() - b * lanes);
    for (std::size_t l = 0; l < in_block; ++l) {
      total[l] = held_[b * lanes + l][1];
      top[l] = exponent(total[l]);
    }
    for (std::size_t first = 0; first < each; first += lanes)
      for (std::size_t l = 0; l < lanes; ++l) {
        const double held = std::abs(solid[first + l] * number[first + l]);
        const int octave = std::clamp(top[l] - exponent(held), 0, kOctaves - 1);
        octaves[first + l] = octave;
        in_octave[l][static_cast<std::size_t>(octave)] += held;
      }
    for (std::size_t l = 0; l < in_block; ++l) {
      int octave = kOctaves - 1;
      for (double sum = in_octave[l].back(); octave >= 0 && sum < kSmall * tolerance_ * total[l];)
        sum += in_octave[l][static_cast<std::size_t>(std::max(0, --octave))];
      smallest_large[l] = octave;
    }
    for (std::size_t first = 0; first < each; first += lanes)
      for (std::size_t l = 0; l < lanes; ++l) {
        const std::size_t at = first + l;
        const Size small = std::abs(solid[at] * number[at]) < kDust * total[l] ? Size::dust : Size::small;
        sizes_[b * each + at] = octaves[at] <= smallest_large[l] ? Size::large : small;
      }
  }
}

bool SmallClasses::emptied(std::span<const double> rates, std::size_t x, std::size_t k, double h) const {
  for (std::size_t q = 0; q < 3; ++q) {
    const std::size_t at = row_->at(x, q * row_->classes() + k);
    if (state_[at] > 0.0 && state_[at] + 0.5 * h * rates[at] < 0.0) return true;
  }
  return false;
}

template <class Do>
void SmallClasses::for_each_fast(double h, Do&& each) const {
  const std::size_t lanes = row_->lanes(), n = row_->classes() * lanes;
  for (std::size_t at = 0; at < loss_.size(); ++at)
    if (is_fast(h, loss_[at])) each(at, at / n * lanes + at % lanes, at % n / lanes);
}

double SmallClasses::limit_by_emptying(std::span<const double> rates, double h) {
  if (!is_fast(h, fastest_)) return h;
  mark_sizes();
  double limit = h;
  for_each_fast(h, [&](std::size_t class_at, std::size_t x, std::size_t k) {
    if (sizes_[class_at] != Size::large) return;
    for (std::size_t q = 0; q < 3; ++q) {
      const std::size_t at = row_->at(x, q * row_->classes() + k);
      if (state_[at] > 0.0 && state_[at] + 0.5 * h * rates[at] < 0.0)
        limit = std::min(limit, kMargin * 2.0 * state_[at] / -rates[at]);
    }
  });
  return limit;
}

double SmallClasses::limit_by_filling(std::span<const double> rates, double h) {
  if (!is_fast(h, fastest_)) return h;
  mark_sizes();
  const std::span<const double> solid = row_->grid().solid();
  std::vector<double> born(row_->compartments(), 0.0);
  for_each_fast(h, [&](std::size_t class_at, std::size_t x, std::size_t k) {
    if (sizes_[class_at] != Size::small || !emptied(rates, x, k, h)) return;
    const std::size_t at = row_->at(x, k);
    born[x] += solid[k] * std::max(0.0, rates[at] + loss_[class_at] * state_[at]);
  });
  double limit = h;
  for (std::size_t x = 0; x < born.size(); ++x)
    if (born[x] > 0.0) limit = std::min(limit, 0.5 * kSmall * tolerance_ * held_[x][1] / born[x]);
  return limit;
}

bool SmallClasses::slow_down(double h) {
  participation_.clear();
  if (!is_fast(caution_ * h, fastest_)) return false;
  mark_sizes();
  bool any = false;
  for_each_fast(caution_ * h, [&](std::size_t at, std::size_t, std::size_t) {
    // Also those whose births make up for it now: the births may stop in a later stage, and repeating the step costs
    // as much as the step (half of all right-hand sides, where a spray wets class after class).
    if (sizes_[at] == Size::large) return;
    if (!any) participation_.assign(row_->class_values(), 1.0);
    participation_[at] = kMargin / (0.5 * caution_ * h * loss_[at]);
    any = true;
  });
  return any;
}

void SmallClasses::check(std::span<const double> stage, double h, bool tolerant, std::span<Negative> accounts) {
  const std::vector<char> negative = negative_blocks(*row_, stage);
  for (std::size_t b = 0; b < row_->blocks(); ++b)
    if (negative[b]) check_block(b, stage, h, tolerant, accounts);
}

void SmallClasses::check_block(std::size_t b, std::span<const double> stage, double h, bool tolerant,
                               std::span<Negative> accounts) {
  mark_sizes();
  const std::size_t lanes = row_->lanes(), each = row_->classes() * lanes;
  const double* value = &stage[b * row_->stride()];
  for (std::size_t entry = 0; entry < 3 * each; ++entry) {
    if (!(value[entry] < 0.0)) continue;
    const std::size_t q = entry / each, k = entry % each / lanes, at = b * each + entry % each;
    Negative& account = accounts[b * lanes + entry % lanes];
    const double part = participation_.empty() ? 1.0 : participation_[at];
    if (tolerant && !is_fast(h, part * loss_[at])) {
      account.amount[q == 0 ? 0 : q + 1] -= value[entry];
      if (q == 0) account.amount[1] -= row_->grid().solid()[k] * value[entry];
    } else if (sizes_[at] == Size::large) {
      account.shorten = true;
    } else {
      account.slowed = true;
      if (participation_.empty()) participation_.assign(row_->class_values(), 1.0);
      participation_[at] = std::min(0.5 * participation_[at], kMargin / (0.5 * h * all_loss_[at]));
    }
  }
}

}  // namespace granary::pbm
