#include "pbm_solver/time/integrator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace granary::pbm {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kMargin = 0.9;  // of the longest step that keeps a class positive
constexpr double kSmall = 0.1;   // of the tolerance: share of a compartment's solids in all small classes together
constexpr double kDust = 1e-12;  // share of a compartment's solids
constexpr double kLongestGrowth = 3.0;
constexpr int kMostAttempts = 200;
constexpr std::size_t kQuantities = 4;  // number, solid volume, liquid, gas
constexpr std::array<const char*, kQuantities> kQuantityNames{"number", "solid volume", "liquid", "gas"};

/// Particles, solid volume, liquid and gas that feed and spray bring between two outputs.
std::array<double, kQuantities> brought_between_outputs(const PbmCase& c, const ClassGrid& grid) {
  std::array<double, kQuantities> sum{};
  if (c.feed)
    for (const ClassRate& one : c.feed->classes) {
      const double solid = one.rate * grid.solid()[grid.index(one.i, one.j)];
      sum[0] += one.rate;
      sum[1] += solid;
      sum[3] += solid * c.feed->porosity / (1.0 - c.feed->porosity);
    }
  if (c.spray) sum[2] = c.spray->rate;
  for (double& rate : sum) rate *= c.output_every;
  return sum;
}

}  // namespace

Integrator::Integrator(CompartmentRow& row, Exchange& exchange, const PbmCase& c, double last_error)
    : row_(&row),
      exchange_(&exchange),
      n_compartments_(static_cast<std::size_t>(c.compartments.count)),
      tolerance_(c.relative_tolerance),
      brought_(brought_between_outputs(c, row.grid())),
      control_(last_error),
      sizes_(row.class_values()),
      slow_down_(row.compartments()),
      shorten_(row.compartments()),
      first_loss_(row.class_values()) {
  for (auto* list : {&f0_, &f1_, &f2_, &f3_, &stage_, &new_state_, &first_rates_}) list->resize(row.size());
}

void Integrator::evaluate(std::span<const double> state, std::span<const double> participation, Inputs inputs,
                          LaneVector& rates) {
  row_->rates(state, participation, inputs, rates);
  ++work_.rhs_evaluations;
}

/// The classes that hold least, together at most kSmall of what the tolerance allows; among them the dust.
void Integrator::mark_small_classes(std::span<const double> state) {
  const std::size_t n = row_->classes();
  const std::span<const double> solid = row_->grid().solid();
  std::vector<std::size_t> order(n);
  for (std::size_t x = 0; x < row_->compartments(); ++x) {
    const auto held = [&](std::size_t k) { return solid[k] * state[row_->at(x, k)]; };
    double total = 0.0, sum = 0.0;
    for (std::size_t k = 0; k < n; ++k) total += held(k);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return std::pair(held(a), a) < std::pair(held(b), b); });
    for (const std::size_t k : order) {
      sum += held(k);
      sizes_[row_->by_class(x, k)] = sum >= kSmall * tolerance_ * total ? Size::large
                                     : held(k) < kDust * total          ? Size::dust
                                                                        : Size::small;
    }
  }
}

/// Whether a class is to be slowed down for a step of h: small, faster than the step, and emptied by it. Dust in any
/// case: its births may stop in a later stage.
bool Integrator::slowed_down(std::span<const double> state, std::size_t x, std::size_t k, double h) const {
  const Size size = sizes_[row_->by_class(x, k)];
  if (size == Size::large || 0.5 * h * first_loss_[row_->by_class(x, k)] <= kMargin) return false;
  return size == Size::dust || emptied(state, x, k, h);
}

bool Integrator::emptied(std::span<const double> state, std::size_t x, std::size_t k, double h) const {
  for (std::size_t q = 0; q < 3; ++q) {
    const std::size_t at = row_->at(x, q * row_->classes() + k);
    if (state[at] + 0.5 * h * first_rates_[at] < 0.0) return true;
  }
  return false;
}

/// The longest step, at most h, that empties no class but those slowed down.
double Integrator::limit_by_emptying(std::span<const double> state, double h) const {
  const std::size_t n = row_->classes();
  double limit = h;
  for (std::size_t x = 0; x < row_->compartments(); ++x)
    for (std::size_t k = 0; k < n; ++k) {
      if (!emptied(state, x, k, h) || slowed_down(state, x, k, h)) continue;
      for (std::size_t q = 0; q < 3; ++q) {
        const std::size_t at = row_->at(x, q * n + k);
        if (state[at] + 0.5 * h * first_rates_[at] < 0.0)
          limit = std::min(limit, kMargin * 2.0 * state[at] / -first_rates_[at]);
      }
    }
  return limit;
}

/// The longest step, at most h, in which what is born into classes slowed down leaves them small: otherwise they would
/// fill up over long steps and have to be emptied in very short ones.
double Integrator::limit_by_filling(std::span<const double> state, double h) const {
  const std::size_t n = row_->classes();
  const std::span<const double> solid = row_->grid().solid();
  double limit = h;
  for (std::size_t x = 0; x < row_->compartments(); ++x) {
    double held = 0.0, born = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const double number = state[row_->at(x, k)], rate = first_rates_[row_->at(x, k)];
      held += solid[k] * number;
      if (sizes_[row_->by_class(x, k)] == Size::small && slowed_down(state, x, k, h))
        born += solid[k] * std::max(0.0, rate + first_loss_[row_->by_class(x, k)] * number);
    }
    if (born > 0.0) limit = std::min(limit, 0.5 * kSmall * tolerance_ * held / born);
  }
  return limit;
}

double Integrator::smallest(double mine) const {
  std::vector<double> each(row_->compartments(), mine), all(n_compartments_);
  exchange_->gather(each, all);
  return *std::min_element(all.begin(), all.end());
}

/// Fills f0_ for a step of at most h, with small classes slowed down as far as they need, and returns the step.
double Integrator::limit_first_stage(std::span<const double> state, Inputs inputs, double h) {
  h = smallest(limit_by_emptying(state, h));
  h = smallest(limit_by_filling(state, h));
  const std::size_t n = row_->classes();
  bool any = false;
  participation_.assign(row_->class_values(), 1.0);
  for (std::size_t x = 0; x < row_->compartments(); ++x)
    for (std::size_t k = 0; k < n; ++k) {
      if (!slowed_down(state, x, k, h)) continue;
      participation_[row_->by_class(x, k)] = kMargin / (0.5 * h * first_loss_[row_->by_class(x, k)]);
      any = true;
    }
  if (smallest(any ? 0.0 : 1.0) == 0.0) {
    evaluate(state, participation_, inputs, f0_);
  } else {
    participation_.clear();
    f0_ = first_rates_;
  }
  return h;
}

/// Notes which compartments have a negative class in a stage, and slows down the small ones among these for a repeated
/// step.
void Integrator::check(std::span<const double> stage) {
  const std::size_t n = row_->classes();
  for (std::size_t x = 0; x < row_->compartments(); ++x)
    for (std::size_t q = 0; q < 3; ++q)
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t at = row_->at(x, q * n + k);
        if (!(stage[at] < 0.0)) continue;
        const bool large = sizes_[row_->by_class(x, k)] == Size::large;
        (large ? shorten_ : slow_down_)[x] = 1.0;
        if (large) continue;
        if (participation_.empty()) participation_.assign(row_->class_values(), 1.0);
        participation_[row_->by_class(x, k)] *= 0.5;
      }
}

void Integrator::run_stages(std::span<const double> u, Inputs inputs, double h) {
  std::fill(slow_down_.begin(), slow_down_.end(), 0.0);
  std::fill(shorten_.begin(), shorten_.end(), 0.0);
  const LaneVector during = participation_;
  const std::size_t size = row_->size();
  for (std::size_t k = 0; k < size; ++k) stage_[k] = u[k] + 0.5 * h * f0_[k];
  check(stage_);
  evaluate(stage_, during, inputs, f1_);
  for (std::size_t k = 0; k < size; ++k) stage_[k] += 0.5 * h * f1_[k];
  check(stage_);
  evaluate(stage_, during, inputs, f2_);
  for (std::size_t k = 0; k < size; ++k) stage_[k] = (2.0 * u[k] + (stage_[k] + 0.5 * h * f2_[k])) / 3.0;
  check(stage_);
  evaluate(stage_, during, inputs, f3_);
  for (std::size_t k = 0; k < size; ++k) new_state_[k] = stage_[k] + 0.5 * h * f3_[k];
  check(new_state_);
}

/// The same on every rank: all look at all compartments in their order.
Integrator::Judgement Integrator::judge(std::span<const double> state, double h) {
  constexpr std::size_t kEach = 2 * kQuantities + 2;
  const std::size_t n = row_->classes();
  std::vector<double> mine(row_->compartments() * kEach), all(n_compartments_ * kEach);
  for (std::size_t x = 0; x < row_->compartments(); ++x) {
    double* error = &mine[x * kEach];
    double* held = error + kQuantities;
    std::array<double, kQuantities> before{};
    for (std::size_t q = 0; q < 3; ++q)
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t at = row_->at(x, q * n + k);
        const double e = std::abs(h * (3.0 * f3_[at] - f0_[at] - f1_[at] - f2_[at]) / 12.0);
        const std::size_t to = q == 0 ? 0 : q + 1;
        error[to] += e, held[to] += new_state_[at], before[to] += state[at];
        if (q > 0) continue;
        const double s = row_->grid().solid()[k];
        error[1] += s * e, held[1] += s * new_state_[at], before[1] += s * state[at];
      }
    for (std::size_t q = 0; q < kQuantities; ++q) held[q] = std::max(held[q], before[q]);
    error[2 * kQuantities] = slow_down_[x];
    error[2 * kQuantities + 1] = shorten_[x];
  }
  exchange_->gather(mine, all);

  Judgement judgement;
  std::array<double, kQuantities> mean = brought_;
  for (std::size_t x = 0; x < n_compartments_; ++x)
    for (std::size_t q = 0; q < kQuantities; ++q)
      mean[q] += all[x * kEach + kQuantities + q] / static_cast<double>(n_compartments_);
  for (std::size_t x = 0; x < n_compartments_; ++x) {
    const double* error = &all[x * kEach];
    const double* held = error + kQuantities;
    if (error[2 * kQuantities] > 0.0 && judgement.verdict == Verdict::fine) judgement.verdict = Verdict::throttle;
    if (error[2 * kQuantities + 1] > 0.0) judgement.verdict = Verdict::shorten;
    for (std::size_t q = 0; q < kQuantities; ++q) {
      double scale = held[q] + 1e-3 * mean[q];
      if (q > 1) scale += 1e-3 * (held[1] + 1e-3 * mean[1]);
      const double relative = error[q] == 0.0 ? 0.0 : error[q] / (tolerance_ * scale);
      if (!(relative <= judgement.error)) {
        judgement.error = std::isnan(relative) ? kInfinity : relative;
        judgement.worst_compartment = static_cast<int>(x);
        judgement.worst_quantity = static_cast<int>(q);
      }
    }
  }
  return judgement;
}

Result<Integrator::Step> Integrator::step(std::span<double> state, double time, Inputs inputs, double h, double longest,
                                          double shortest) {
  row_->begin_step(state, false);
  mark_small_classes(state);
  evaluate(state, {}, inputs, first_rates_);
  for (std::size_t b = 0; b < row_->blocks(); ++b)
    std::copy(row_->loss_rate(b).begin(), row_->loss_rate(b).end(),
              first_loss_.begin() + static_cast<std::ptrdiff_t>(b * row_->classes() * row_->lanes()));
  const double asked = h;
  Judgement last;
  bool repeat = false;  // the same step again, with classes slowed down further
  for (int attempt = 0; attempt < kMostAttempts && h >= shortest; ++attempt) {
    if (repeat) {
      evaluate(state, participation_, inputs, f0_);
    } else {
      h = limit_first_stage(state, inputs, h);
    }
    run_stages(state, inputs, h);
    last = judge(state, h);
    repeat = last.verdict == Verdict::throttle && attempt % 8 != 7;
    if (last.verdict == Verdict::fine && last.error <= 1.0) {
      std::copy(new_state_.begin(), new_state_.end(), state.begin());
      ++work_.steps;
      return Step{h, next_step(h, longest, h == asked && h < longest, last.error)};
    }
    ++work_.rejected;
    if (!repeat) h *= last.verdict == Verdict::fine ? StepControl::rejected(last.error) : 0.5;
  }
  return too_hard(time, h, last);
}

/// A step cut short by an output time says nothing against the longer one that was wanted, and is not remembered.
double Integrator::next_step(double taken, double longest, bool was_cut, double error) {
  if (was_cut) return std::max(longest, taken * StepControl(control_).accepted(error, kLongestGrowth));
  return taken * control_.accepted(error, kLongestGrowth);
}

Error Integrator::too_hard(double time, double h, const Judgement& last) const {
  return {fmt::format(
              "the tolerance cannot be kept: at {:g} s the step fell to {:g} s, compartment {}, because {}. "
              "Look at /relative_tolerance (now {:g}), /aggregation/rate, /breakage/rate and the rates in /dem, and at "
              "/grid (its largest classes may react far faster than the rest).",
              time, h, last.worst_compartment,
              last.verdict == Verdict::shorten ? std::string("a class would become negative")
                                               : fmt::format("of its {}", kQuantityNames[last.worst_quantity]),
              tolerance_),
          kToleranceNotKept};
}

}  // namespace granary::pbm
