#include "pbm_solver/time/integrator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace granary::pbm {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNegative = 0.1;  // of the tolerance: share of what is held that may be below 0 in a stage
constexpr double kLongestGrowth = 3.0;
constexpr int kMostAttempts = 200;
constexpr std::array<const char*, 4> kQuantityNames{"number", "solid volume", "liquid", "gas"};

/// Particles, solid volume, liquid and gas that feed and spray bring between two outputs.
Held brought_between_outputs(const PbmCase& c, const ClassGrid& grid) {
  Held sum{};
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

Integrator::Integrator(CompartmentRow& row, Exchange& exchange, const PbmCase& c, double last_error, int threads)
    : row_(&row),
      exchange_(&exchange),
      n_compartments_(static_cast<std::size_t>(c.compartments.count)),
      threads_(std::min(threads, static_cast<int>(row.blocks()))),
      tolerance_(c.relative_tolerance),
      born_negative_(row.tables().aggregation && row.tables().aggregation->form == AggregationTables::Form::low_rank),
      brought_(brought_between_outputs(c, row.grid())),
      control_(last_error),
      explicit_(explicit_method()),
      implicit_explicit_(implicit_explicit_method()),
      method_(&explicit_),
      small_(row, c.relative_tolerance),
      stiff_(row, threads),
      negative_(row.compartments()),
      before_(row.compartments()),
      after_(row.compartments()),
      off_(row.compartments()) {
  for (auto* list : {&first_rates_, &stage_, &right_hand_side_, &error_}) list->resize(row.size());
  for (LaneVector& list : e_) list.resize(row.size());
  if (stiff_.exists())
    for (LaneVector& list : b_) list.resize(row.size());
}

/// E(state): all rates, less B state where that is taken implicitly.
void Integrator::evaluate(std::span<const double> state, std::span<const double> participation, Inputs inputs,
                          LaneVector& rates) {
  // Selection rates that follow the particles differ from the frozen ones within the step; the difference is explicit.
  const bool breakage = !method_->implicit() || row_->block(0).looks_at_particles();
  row_->rates(state, participation, inputs, rates, breakage);
  if (method_->implicit()) stiff_.add(-1.0, state, rates, breakage);
  ++work_.rhs_evaluations;
}

double Integrator::smallest(double mine) const {
  std::vector<double> each(row_->compartments(), mine), all(n_compartments_);
  exchange_->gather(each, all);
  return *std::min_element(all.begin(), all.end());
}

/// What a step of h starts with: rates, and the method for it.
void Integrator::begin(std::span<const double> state, Inputs inputs, double h) {
  row_->begin_step(state, false);
  sum_magnitudes(*row_, state, before_);
  small_.begin_step(state, before_);
  method_ = &explicit_;
  evaluate(state, {}, inputs, first_rates_);
  if (stiff_.exists()) {
    stiff_.freeze();
    const bool here = stiff_.needed(state, first_rates_, h, before_, tolerance_);
    if (smallest(here ? 0.0 : 1.0) == 0.0) method_ = &implicit_explicit_;
  }
  small_.set_losses(method_->implicit() ? stiff_.rate() : std::span<const double>());
  if (method_->implicit()) stiff_.add(-1.0, state, first_rates_);
}

/// Fills e_[0] for a step of at most h, with small classes slowed down as far as they need, and returns the step.
double Integrator::limit_first_stage(std::span<const double> state, Inputs inputs, double h) {
  h = smallest(small_.limit_by_emptying(first_rates_, h));
  h = smallest(small_.limit_by_filling(first_rates_, h));
  const bool any = small_.slow_down(h);
  if (method_->implicit()) stiff_.slow_down(small_.participation());
  if (smallest(any ? 0.0 : 1.0) == 0.0) {
    evaluate(state, small_.participation(), inputs, e_[0]);
  } else {
    combine(first_rates_.data(), {}, e_[0], threads_);
  }
  return h;
}

/// stage_ = Y_i, and b_[i] = B Y_i.
void Integrator::take_stage(std::span<const double> state, std::size_t i, double h) {
  std::array<Term, 2 * AdditiveMethod::kMost> terms{};
  std::size_t n = 0;
  for (std::size_t j = 0; j < i; ++j) {
    if (method_->e[i][j] != 0.0) terms[n++] = {h * method_->e[i][j], e_[j].data()};
    if (method_->b[i][j] != 0.0) terms[n++] = {h * method_->b[i][j], b_[j].data()};
  }
  if (!method_->implicit()) return combine(state.data(), std::span(terms).first(n), stage_, threads_);
  combine(state.data(), std::span(terms).first(n), right_hand_side_, threads_);
  combine(right_hand_side_.data(), {}, stage_, threads_);
  const double gamma = h * method_->gamma;
  stiff_.solve(gamma, stage_);
  const std::array<Term, 2> change{{{1.0 / gamma, stage_.data()}, {-1.0 / gamma, right_hand_side_.data()}}};
  combine(nullptr, change, b_[i], threads_);
}

void Integrator::estimate_error(double h) {
  std::array<Term, 2 * AdditiveMethod::kMost> terms{};
  std::size_t n = 0;
  for (std::size_t j = 0; j < AdditiveMethod::kMost; ++j) {
    if (method_->error_e[j] != 0.0) terms[n++] = {h * method_->error_e[j], e_[j].data()};
    if (method_->error_b[j] != 0.0) terms[n++] = {h * method_->error_b[j], b_[j].data()};
  }
  combine(nullptr, std::span(terms).first(n), error_, threads_);
  // What decays at once is no error of a method that lets it decay.
  if (method_->implicit()) stiff_.solve(h * method_->gamma, error_);
}

void Integrator::run_stages(std::span<const double> state, Inputs inputs, double h) {
  std::fill(negative_.begin(), negative_.end(), SmallClasses::Negative{});
  const LaneVector during(small_.participation().begin(), small_.participation().end());
  for (std::size_t i = 1; i <= method_->evaluations; ++i) {
    take_stage(state, i, h);
    const bool tolerant = born_negative_ || (method_->implicit() && i < method_->evaluations);
    small_.check(stage_, h, tolerant, negative_);
    if (i < method_->evaluations) evaluate(stage_, during, inputs, e_[i]);
  }
  estimate_error(h);
}

/// The same on every rank: all look at all compartments in their order.
Integrator::Judgement Integrator::judge() {
  constexpr std::size_t kQuantities = std::tuple_size_v<Held>, kEach = 3 * kQuantities + 2;
  std::vector<double> mine(row_->compartments() * kEach), all(n_compartments_ * kEach);
  sum_magnitudes(*row_, stage_, after_);
  sum_magnitudes(*row_, error_, off_);
  for (std::size_t x = 0; x < row_->compartments(); ++x) {
    double* one = &mine[x * kEach];
    for (std::size_t q = 0; q < kQuantities; ++q) {
      one[q] = off_[x][q];
      one[kQuantities + q] = std::max(before_[x][q], after_[x][q]);
      one[2 * kQuantities + q] = negative_[x].amount[q];
    }
    one[3 * kQuantities] = negative_[x].slowed ? 1.0 : 0.0;
    one[3 * kQuantities + 1] = negative_[x].shorten ? 1.0 : 0.0;
  }
  exchange_->gather(mine, all);

  Judgement judgement;
  Held mean = brought_;
  for (std::size_t x = 0; x < n_compartments_; ++x)
    for (std::size_t q = 0; q < kQuantities; ++q)
      mean[q] += all[x * kEach + kQuantities + q] / static_cast<double>(n_compartments_);
  for (std::size_t x = 0; x < n_compartments_; ++x) {
    const double *error = &all[x * kEach], *held = error + kQuantities, *negative = held + kQuantities;
    if (negative[kQuantities] > 0.0 && judgement.verdict == Verdict::fine) judgement.verdict = Verdict::throttle;
    if (negative[kQuantities + 1] > 0.0) judgement.verdict = Verdict::shorten;
    for (std::size_t q = 0; q < kQuantities; ++q) {
      double scale = held[q] + 1e-3 * mean[q];
      if (q > 1) scale += 1e-3 * (held[1] + 1e-3 * mean[1]);
      if (negative[q] > kNegative * tolerance_ * scale) judgement.verdict = Verdict::shorten;
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
  begin(state, inputs, h);
  const double asked = h;
  Judgement last;
  bool repeat = false;  // the same step again, with classes slowed down further
  for (int attempt = 0; attempt < kMostAttempts && h >= shortest; ++attempt) {
    if (repeat) {
      if (method_->implicit()) stiff_.slow_down(small_.participation());
      evaluate(state, small_.participation(), inputs, e_[0]);
    } else {
      h = limit_first_stage(state, inputs, h);
    }
    run_stages(state, inputs, h);
    last = judge();
    repeat = last.verdict == Verdict::throttle && attempt % 8 != 7;
    if (last.verdict == Verdict::fine && last.error <= 1.0) {
      combine(stage_.data(), {}, state, threads_);
      ++work_.steps;
      if (method_->implicit()) ++work_.implicit_steps;
      return Step{h, next_step(h, longest, h == asked && h < longest, last.error)};
    }
    ++work_.rejected;
    if (repeat) continue;
    h *= last.verdict == Verdict::fine ? StepControl::rejected(last.error) : 0.5;
    if (method_->implicit()) begin(state, inputs, h);
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
