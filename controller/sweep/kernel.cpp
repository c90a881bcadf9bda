#include "controller/sweep/kernel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include "common/json/io.hpp"
#include "common/math/percentile.hpp"

namespace granary::sweep {
namespace {

constexpr long kEnoughForALaw = 30;  // splits of a cause
constexpr double kPrior = 3.0;       // of the exponents: wide beside what the counts know

constexpr int kReplicas = 200;         // of the bootstrap
constexpr double kLeastPower = 1e-10;  // [W] a sphere, where nothing hits

using Records = std::vector<estimation::SizeRecord>;  // of one case

std::vector<double> features_of(double size, const ResolvedCase& one, const std::string& cause, KernelOptions::By by) {
  const double ln = std::log(size / one.spheres);
  std::vector<double> features{1.0, ln, ln * ln};
  if (by == KernelOptions::By::impacts)
    features.push_back(std::log(std::max(kLeastPower, one.impacts.on(cause))));
  else
    features.insert(features.end(), one.ln_setting.begin(), one.ln_setting.end());
  return features;
}

/// Where a case lies for the law: what its features have beside the size.
std::vector<double> place_of(const ResolvedCase& one, const std::string& cause, KernelOptions::By by) {
  const auto features = features_of(1.0, one, cause, by);
  return {features.begin() + 3, features.end()};
}

long splits_by(const estimation::SizeRecord& record, const std::set<std::string>& causes) {
  long n = 0;
  for (const auto& [cause, splits] : record.splits)
    if (causes.count(cause) == 1) n += splits;
  return n;
}

/// What breaks together: causes by name, those with too few splits as "others".
using CauseGroups = std::map<std::string, std::set<std::string>>;

/// records: of each case.
Result<estimation::SelectionLaw> law_of(const std::vector<ResolvedCase>& cases, const std::vector<Records>& records,
                                        const CauseGroups::value_type& group, KernelOptions::By by) {
  std::vector<estimation::CountedEvents> counts;
  for (std::size_t k = 0; k < cases.size(); ++k)
    for (const estimation::SizeRecord& record : records[k])
      if (cases[k].trained && record.exposure > 0.0)
        counts.push_back({features_of(record.mean_size, cases[k], group.first, by), record.exposure,
                          static_cast<double>(splits_by(record, group.second))});
  return estimation::fit_selection_law(counts, kPrior);
}

std::vector<BreakageKernel::SplitsOfCase> seen_by(const std::vector<ResolvedCase>& cases,
                                                  const CauseGroups::value_type& group, KernelOptions::By by) {
  std::vector<BreakageKernel::SplitsOfCase> seen;
  for (const ResolvedCase& one : cases) {
    if (!one.trained) continue;
    seen.push_back({place_of(one, group.first, by), {}});
    for (const estimation::FragmentSample& sample : one.history)
      std::copy_if(sample.splits.begin(), sample.splits.end(), std::back_inserter(seen.back().splits),
                   [&](const estimation::Split& split) { return group.second.count(split.cause) == 1; });
  }
  return seen;
}

std::vector<Records> records_of(const std::vector<ResolvedCase>& cases) {
  std::vector<Records> all;
  for (const ResolvedCase& one : cases) all.push_back(one.records);
  return all;
}

/// Of as many agglomerates of each case as it has, drawn with replacement: pieces of one agglomerate break together,
/// agglomerates for themselves.
std::vector<Records> redrawn(const std::vector<ResolvedCase>& cases, std::mt19937_64& dice) {
  std::vector<Records> all;
  for (const ResolvedCase& one : cases) {
    const std::size_t n = one.agglomerates.size();
    std::vector<long> times(n, 0);
    for (std::size_t draw = 0; draw < n; ++draw) ++times[dice() % n];
    const auto bounds = estimation::size_bounds(one.spheres);
    std::vector<estimation::SizeSums> sums(bounds.size() - 1);
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t c = 0; c < sums.size() && times[a] > 0; ++c) sums[c].add(one.agglomerates[a][c], times[a]);
    all.push_back(estimation::records_of(sums, bounds));
  }
  return all;
}

/// Coefficients of each cause's law, fitted again and again to agglomerates drawn anew. A draw in which a cause has no
/// split at all counts nowhere. Nothing where the agglomerates are not told apart.
void bootstrap(const std::vector<ResolvedCase>& cases, const CauseGroups& groups, BreakageKernel& kernel) {
  if (std::any_of(cases.begin(), cases.end(),
                  [](const ResolvedCase& one) { return one.trained && one.agglomerates.empty(); }))
    return;
  std::mt19937_64 dice(1);
  for (int replica = 0; replica < kReplicas; ++replica) {
    const auto records = redrawn(cases, dice);
    std::vector<std::vector<double>> coefficients;
    for (const auto& group : groups)
      if (const auto law = law_of(cases, records, group, kernel.by)) coefficients.push_back(law->coefficient);
    if (coefficients.size() != groups.size()) continue;
    for (std::size_t g = 0; g < groups.size(); ++g) kernel.causes[g].replicas.push_back(std::move(coefficients[g]));
  }
}

/// The middle 95 %.
std::pair<double, double> interval_of(const std::vector<double>& values) {
  return {percentile(values, 0.025), percentile(values, 0.975)};
}

CauseGroups groups_of(const std::vector<ResolvedCase>& cases, std::map<std::string, long>& splits) {
  std::map<std::string, long> all;
  for (const ResolvedCase& one : cases)
    for (const estimation::SizeRecord& record : one.records)
      for (const auto& [cause, n] : record.splits)
        if (one.trained) all[cause] += n;
  CauseGroups groups;
  for (const auto& [cause, n] : all) {
    const std::string group = n >= kEnoughForALaw ? cause : "others";
    groups[group].insert(cause);
    splits[group] += n;
  }
  return groups;
}

std::vector<estimation::WeightedSplits> weighted(const BreakageKernel::CauseLaw& cause, const ResolvedCase& one,
                                                 KernelOptions::By by) {
  const auto at = place_of(one, cause.cause, by);
  std::vector<double> squares;
  for (const BreakageKernel::SplitsOfCase& seen : cause.seen) {
    double square = 0.0;
    for (std::size_t j = 0; j < at.size(); ++j) square += std::pow((at[j] - seen.at[j]) / BreakageKernel::kNear, 2);
    squares.push_back(square);
  }
  // From the nearest on: where all are far, the nearest tells.
  const double least = *std::min_element(squares.begin(), squares.end());
  std::vector<estimation::WeightedSplits> groups;
  for (std::size_t k = 0; k < squares.size(); ++k)
    groups.push_back({&cause.seen[k].splits, std::max(1e-12, std::exp(-0.5 * (squares[k] - least)))});
  return groups;
}

json::Value rate_json(const estimation::Rate& rate) {
  return json::Value(json::Array{rate.value, rate.low, rate.high});
}

}  // namespace

std::pair<double, double> BreakageKernel::CauseLaw::interval(std::size_t j) const {
  const double c = law.coefficient[j], error = 1.959963984540054 * std::sqrt(law.covariance[j][j]);
  if (replicas.empty()) return {c - error, c + error};
  std::vector<double> drawn;
  for (const auto& coefficients : replicas) drawn.push_back(coefficients[j]);
  return interval_of(drawn);
}

estimation::Rate BreakageKernel::rate(double size, const ResolvedCase& one) const {
  estimation::Rate sum;
  double below = 0.0, above = 0.0;
  std::vector<double> drawn(causes.empty() ? 0 : causes.front().replicas.size(), 0.0);
  for (const CauseLaw& cause : causes) {
    const auto features = features_of(size, one, cause.cause, by);
    const auto part = cause.law.at(features);
    sum.value += part.value;
    below += std::pow(part.value - part.low, 2);
    above += std::pow(part.high - part.value, 2);
    for (std::size_t r = 0; r < drawn.size(); ++r)
      drawn[r] += std::exp(std::inner_product(features.begin(), features.end(), cause.replicas[r].begin(), 0.0));
  }
  if (drawn.empty()) {  // as if the causes' errors were independent: their variances add
    sum.low = std::max(0.0, sum.value - std::sqrt(below));
    sum.high = sum.value + std::sqrt(above);
  } else {
    std::tie(sum.low, sum.high) = interval_of(drawn);
  }
  return sum;
}

pbm::BreakageTable BreakageKernel::table(const ResolvedCase& one) const {
  std::vector<std::vector<estimation::WeightedSplits>> by_cause;
  std::vector<estimation::WeightedSplits> by_any;
  for (const CauseLaw& cause : causes) {
    by_cause.push_back(weighted(cause, one, by));
    by_any.insert(by_any.end(), by_cause.back().begin(), by_cause.back().end());
  }
  pbm::BreakageTable table;
  std::size_t nearest = 0;  // class whose parents were seen to break
  while (nearest + 1 < splits.size() && splits[nearest] == 0) ++nearest;
  for (std::size_t c = 0; c + 1 < bounds.size(); ++c) {
    if (splits[c] > 0) nearest = c;
    const int from = bounds[nearest], to = bounds[nearest + 1] - 1;
    const double size = std::sqrt(static_cast<double>(bounds[c]) * (bounds[c + 1] - 1));
    table.solid.push_back(size * one.sphere_volume);
    table.rate.push_back(rate(size, one).value);
    table.daughters.emplace_back();
    for (std::size_t k = 0; k < causes.size(); ++k) {
      const double share = causes[k].law.at(features_of(size, one, causes[k].cause, by)).value / table.rate.back();
      auto daughters = estimation::mean_daughters(by_cause[k], from, to);
      if (daughters.empty()) daughters = estimation::mean_daughters(by_any, from, to);
      for (const estimation::MeanDaughter& daughter : daughters)
        table.daughters.back().push_back({daughter.share, share * daughter.number});
    }
  }
  return table;
}

Result<BreakageKernel> fit_kernel(const std::vector<ResolvedCase>& cases, const std::vector<std::string>& settings,
                                  KernelOptions::By by) {
  BreakageKernel kernel;
  kernel.by = by;
  if (by == KernelOptions::By::settings) kernel.settings = settings;
  kernel.spheres = cases.front().spheres;
  kernel.bounds = estimation::size_bounds(kernel.spheres);
  std::map<std::string, long> splits;
  const CauseGroups groups = groups_of(cases, splits);
  const auto records = records_of(cases);
  for (const auto& group : groups) {
    GRANARY_TRY(auto law, law_of(cases, records, group, by));
    kernel.causes.push_back({group.first, splits[group.first], std::move(law), {}, seen_by(cases, group, by)});
  }
  if (kernel.causes.empty()) return Error{"nothing broke in the cases that were to be fitted."};
  bootstrap(cases, groups, kernel);
  kernel.splits.assign(kernel.bounds.size() - 1, 0);
  for (std::size_t k = 0; k < cases.size(); ++k)
    for (std::size_t c = 0; c < kernel.splits.size() && cases[k].trained; ++c)
      kernel.splits[c] += cases[k].records[c].all_splits();
  return kernel;
}

std::vector<std::string> features_of(const BreakageKernel& kernel) {
  std::vector<std::string> features{"1", fmt::format("ln(spheres/{})", kernel.spheres),
                                    fmt::format("ln^2(spheres/{})", kernel.spheres)};
  for (const std::string& setting : kernel.settings) features.push_back("ln(" + setting + ")");
  if (kernel.by == KernelOptions::By::impacts) features.push_back("ln(impact power/W)");
  return features;
}

json::Value to_json(const BreakageKernel& kernel) {
  json::Value causes = json::Value::array();
  for (const BreakageKernel::CauseLaw& one : kernel.causes) {
    json::Value intervals = json::Value::array();
    for (std::size_t j = 0; j < one.law.coefficient.size(); ++j) {
      const auto [low, high] = one.interval(j);
      intervals.push(json::Array{low, high});
    }
    causes.push(json::Value::object({{"cause", one.cause},
                                     {"splits", static_cast<std::int64_t>(one.splits)},
                                     {"coefficients", one.law.coefficient},
                                     {"intervals_95", std::move(intervals)},
                                     {"replicas", one.replicas.size()},
                                     {"dispersion", one.law.dispersion}}));
  }
  const bool drawn = !kernel.causes.empty() && !kernel.causes.front().replicas.empty();
  return json::Value::object({{"format", "granary-breakage-law-1"},
                              {"features", features_of(kernel)},
                              {"spheres", kernel.spheres},
                              {"intervals", drawn ? "bootstrap over agglomerates" : "likelihood"},
                              {"causes", std::move(causes)}});
}

json::Value kernel_file(const BreakageKernel& kernel, const ResolvedCase& one) {
  json::Value classes = json::Value::array();
  for (std::size_t c = 0; c < one.records.size(); ++c) {
    const estimation::SizeRecord& record = one.records[c];
    classes.push(json::Value::object(
        {{"spheres", json::Array{record.from, record.to}},
         {"exposure_s", record.exposure},
         {"splits", static_cast<std::int64_t>(record.all_splits())},
         {"measured_rate_1_s", rate_json(estimation::rate_of(record.all_splits(), record.exposure))},
         {"rate_1_s", rate_json(kernel.rate(std::sqrt(static_cast<double>(record.from) * record.to), one))},
         {"daughters_of_splits", static_cast<std::int64_t>(kernel.splits[c])}}));
  }
  return json::Value::object({{"format", "granary-breakage-kernel-1"},
                              {"table", pbm::to_json(kernel.table(one))},
                              {"evidence", json::Value::object({{"case", one.name},
                                                                {"settings", one.values},
                                                                {"fitted_to_it", one.trained},
                                                                {"classes", std::move(classes)}})}});
}

}  // namespace granary::sweep
