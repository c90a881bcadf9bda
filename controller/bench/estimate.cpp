#include "controller/bench/estimate.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

namespace granary::bench {
namespace {

double mean_of(const std::vector<double>& x) {
  return x.empty() ? 0.0 : std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
}

/// Squared standard error of the mean of independent values.
double squared_error(const std::vector<double>& x) {
  if (x.size() < 2) return 0.0;
  const double mean = mean_of(x), n = static_cast<double>(x.size());
  double sum = 0.0;
  for (const double v : x) sum += (v - mean) * (v - mean);
  return sum / (n - 1.0) / n;
}

/// Squared standard error of each batch's mean over the runs, as if batches were independent.
double squared_batch_error(const std::vector<std::vector<double>>& run, std::size_t n_batches) {
  double sum = 0.0;
  for (std::size_t b = 0; b < n_batches; ++b) {
    std::vector<double> over_runs;
    for (const auto& one : run) over_runs.push_back(one[b]);
    sum += squared_error(over_runs);
  }
  return sum / static_cast<double>(n_batches * n_batches);
}

}  // namespace

Estimate estimate(const Measured& measured) {
  Estimate e;
  e.runs = measured.run.size();
  if (e.runs == 0) return e;
  std::size_t n_batches = measured.run.front().size();
  for (const auto& one : measured.run) n_batches = std::min(n_batches, one.size());
  if (n_batches == 0) return e;
  e.batches = e.runs * n_batches;
  std::vector<double> means;
  for (const auto& one : measured.run)
    means.push_back(mean_of({one.begin(), one.begin() + static_cast<std::ptrdiff_t>(n_batches)}));
  e.mean = mean_of(means);
  const double batches =
      e.runs > 1 ? squared_batch_error(measured.run, n_batches) : squared_error(measured.run.front());
  e.error = std::sqrt(std::max(batches, e.runs > 2 ? squared_error(means) : 0.0));
  return e;
}

double Difference::relative_error() const {
  return a.mean != 0.0 && b.mean != 0.0 ? std::abs(b.mean / a.mean) * std::hypot(a.error / a.mean, b.error / b.mean)
                                        : 0.0;
}

double Difference::z() const {
  const double error = std::hypot(a.error, b.error), difference = b.mean - a.mean;
  return error > 0.0 ? difference / error : difference == 0.0 ? 0.0 : std::copysign(HUGE_VAL, difference);
}

std::vector<Difference> differences(const std::vector<Measured>& a, const std::vector<Measured>& b) {
  std::vector<Difference> all;
  for (const Measured& one : a) {
    const auto other = std::find_if(b.begin(), b.end(), [&](const Measured& m) { return m.name == one.name; });
    if (other != b.end()) all.push_back({one.name, one.unit, estimate(one), estimate(*other)});
  }
  return all;
}

double largest_z(std::size_t n, std::size_t freedom, double p) {
  const boost::math::students_t t(static_cast<double>(std::max<std::size_t>(1, freedom)));
  return boost::math::quantile(boost::math::complement(t, p / static_cast<double>(std::max<std::size_t>(1, n)) / 2.0));
}

json::Value to_json(const Estimate& e) {
  return json::Value::object({{"mean", e.mean}, {"error", e.error}, {"runs", e.runs}, {"batches", e.batches}});
}

json::Value to_json(const std::vector<Difference>& all) {
  json::Value rows = json::Value::array();
  for (const Difference& d : all)
    rows.push(json::Value::object({{"quantity", d.name},
                                   {"unit", d.unit},
                                   {"stock", d.a.mean},
                                   {"stock_error", d.a.error},
                                   {"granary", d.b.mean},
                                   {"granary_error", d.b.error},
                                   {"difference", d.relative()},
                                   {"z", d.z()}}));
  return rows;
}

}  // namespace granary::bench
