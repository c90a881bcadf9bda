#include "controller/monitor/criteria.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/assert.hpp"
#include "controller/monitor/series_error.hpp"
#include "controller/monitor/tallies.hpp"

namespace granary::monitor {

namespace {
constexpr std::size_t kBatches = 10;

std::string place(const Property& property) {
  return property.where.empty() || property.where == "all" ? property.name : property.name + " in " + property.where;
}
}  // namespace

/// Of a run of rows: mean, its standard error, the floor of its denominator. `value` is NaN if any row is too thin.
struct Criteria::Mean {
  double value = 0.0, error = 0.0, floor = 0.0;
  bool known() const { return std::isfinite(value); }
  double denominator() const { return std::max(std::abs(value), floor); }
};

Criteria::Criteria(Options options, std::vector<Property> properties)
    : options_(options), properties_(std::move(properties)) {
  GRANARY_ASSERT(options_.average >= 1);
}

Criteria::Mean Criteria::mean(std::size_t property, std::size_t first, std::size_t count) const {
  Mean result;
  double variance = 0.0, worst = 0.0;
  for (std::size_t r = first; r < first + count; ++r) {
    const Sample& sample = rows_[r].samples[property];
    result.value += sample.value;
    result.floor += sample.floor;
    variance += sample.error * sample.error;
    worst = std::max(worst, sample.error);
  }
  const auto n = static_cast<double>(count);
  result.value /= n;
  result.floor /= n;
  // The same particles are in every row: their mean speed is not surer for being looked at twice.
  result.error = properties_[property].independent ? std::sqrt(variance) / n : worst;
  return result;
}

Verdict Criteria::verdict(Outcome outcome, const Property* property) const {
  Verdict said;
  said.outcome = outcome;
  if (property != nullptr) {
    said.watched = property->name;
    said.where = property->where;
  }
  said.time = rows_.empty() ? 0.0 : rows_.back().end;
  said.burst_start = burst_start();
  said.lines = rows_.size();
  return said;
}

Verdict Criteria::add(Row row) {
  GRANARY_ASSERT(row.samples.size() == properties_.size());
  rows_.push_back(std::move(row));
  while (first_ < rows_.size() && rows_[first_].begin < burst_start() + options_.grace - kInstant) ++first_;
  for (const auto& test : {&Criteria::drifted, &Criteria::steady, &Criteria::converged})
    if (Verdict said = (this->*test)(); said.outcome != Outcome::none) return said;
  return {};
}

Verdict Criteria::ended() const {
  Verdict said = verdict(Outcome::ended, nullptr);
  said.message = fmt::format("the program ended at {:.6g} s with nothing to report", said.time);
  return said;
}

/// Whoever looks often enough sees any noise: the bound grows with the number of looks, one a row.
double Criteria::errors_allowed(std::size_t looks) const {
  return std::sqrt(options_.significance * options_.significance + 2.0 * std::log(static_cast<double>(looks)));
}

Verdict Criteria::drifted() const {
  const auto span = static_cast<std::size_t>(options_.average);
  if (!options_.watch_drift || rows_.size() < first_ + 2 * span) return {};
  const double allowed = errors_allowed(rows_.size() - first_ - span);
  Verdict worst;
  for (std::size_t p = 0; p < properties_.size(); ++p) {
    const Mean before = mean(p, first_, span), now = mean(p, rows_.size() - span, span);
    if (!before.known() || !now.known() || before.denominator() <= 0.0) continue;
    const double change = (now.value - before.value) / before.denominator();
    const double noise = std::hypot(before.error, now.error) / before.denominator();
    if (std::abs(change) <= options_.threshold || std::abs(change) <= allowed * noise) continue;
    if (std::abs(change) <= std::abs(worst.change)) continue;
    worst = verdict(Outcome::drifted, &properties_[p]);
    worst.reference = before.value;
    worst.value = now.value;
    worst.change = change;
    worst.noise = noise;
    worst.threshold = options_.threshold;
    worst.message = fmt::format("{} moved by {:+.3g} % ({:.4g} -> {:.4g}) since {:.6g} s", place(properties_[p]),
                                100.0 * change, before.value, now.value, rows_[first_].begin);
  }
  return worst;
}

Verdict Criteria::steady() const {
  const auto span = static_cast<std::size_t>(options_.average);
  if (!(options_.steady_window > 0.0) || first_ >= rows_.size()) return {};
  const double from = rows_.back().end - options_.steady_window;
  if (rows_[first_].begin > from + kInstant) return {};
  std::size_t first = rows_.size();
  while (first > first_ && rows_[first - 1].begin >= from - kInstant) --first;
  if (rows_.size() < first + 2 * span) return {};

  const double allowed = std::sqrt(2.0) * errors_allowed(rows_.size() - first);  // max and min both have an error
  Verdict most = verdict(Outcome::steady, nullptr);
  bool sure = false;
  for (std::size_t p = 0; p < properties_.size(); ++p) {
    const Mean all = mean(p, first, rows_.size() - first);
    if (!all.known() || all.denominator() <= 0.0) continue;
    double low = all.value, high = all.value, error = 0.0;
    for (std::size_t r = first; r + span <= rows_.size(); ++r) {
      const Mean here = mean(p, r, span);
      low = std::min(low, here.value);
      high = std::max(high, here.value);
      error = std::max(error, here.error);
    }
    const double change = (high - low) / all.denominator();
    const double noise = error / all.denominator();
    if (change > std::max(options_.threshold, allowed * noise)) return {};
    if (allowed * noise > options_.threshold) continue;  // it moved no more than its noise does: says nothing
    if (sure && change <= most.change) continue;
    sure = true;
    most.watched = properties_[p].name;
    most.where = properties_[p].where;
    most.reference = all.value;
    most.value = rows_.back().samples[p].value;
    most.change = change;
    most.noise = noise;
    most.threshold = options_.threshold;
    most.message = fmt::format("nothing moved by more than {:.3g} % from {:.6g} s to {:.6g} s; most: {}, {:.3g} %",
                               100.0 * options_.threshold, rows_[first].begin, rows_.back().end, place(properties_[p]),
                               100.0 * change);
  }
  return sure ? most : Verdict{};
}

Verdict Criteria::converged() const {
  const std::size_t n = rows_.size() - first_;
  if (!(options_.converged_tolerance > 0.0) || n < kBatches) return {};
  const std::size_t batch = n / kBatches, first = rows_.size() - batch * kBatches;
  Verdict least = verdict(Outcome::converged, nullptr);
  bool any = false;
  for (std::size_t p = 0; p < properties_.size(); ++p) {
    const Mean all = mean(p, first, batch * kBatches);
    if (!all.known() || all.denominator() <= 0.0) continue;
    std::array<double, kBatches> batches;
    for (std::size_t b = 0; b < kBatches; ++b) batches[b] = mean(p, first + b * batch, batch).value;
    const double scatter = error_of_mean(batches);
    // Counting is the least error a count can have; for a mean over the same particles the scatter in time is what
    // matters.
    const double error = std::max(scatter, properties_[p].independent ? all.error : 0.0) / all.denominator();
    if (error > options_.converged_tolerance) return {};
    if (any && error <= least.change) continue;
    any = true;
    least.watched = properties_[p].name;
    least.where = properties_[p].where;
    least.reference = least.value = all.value;
    least.change = least.noise = error;
    least.threshold = options_.converged_tolerance;
    least.message = fmt::format("every watched mean is known to {:.3g} % or better; least: {}, {:.4g} +- {:.2g} %",
                                100.0 * options_.converged_tolerance, place(properties_[p]), all.value, 100.0 * error);
  }
  return any ? least : Verdict{};
}

}  // namespace granary::monitor
