#include "controller/sweep/kernel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "common/json/io.hpp"
#include "common/units.hpp"
#include "controller/sweep/cases.hpp"
#include "controller/sweep/outcome.hpp"

namespace granary::sweep {
namespace {

namespace fs = std::filesystem;
using campaign::Campaign;
using campaign::Sweep;
using campaign::SweepCase;

constexpr long kEnoughForALaw = 30;  // splits of a cause
constexpr double kPrior = 3.0;       // of the exponents: wide beside what the counts know

/// A repetition is no condition.
bool is_seed(const std::string& pointer) { return pointer.ends_with("/seed"); }

bool is_held_out(const ResolvedCase& one, const std::vector<std::string>& held_out) {
  return std::any_of(held_out.begin(), held_out.end(), [&](const std::string& word) {
    return word == one.name || std::find(one.values.begin(), one.values.end(), word) != one.values.end();
  });
}

Result<ResolvedCase> read_resolved(const SweepCase& from, const fs::path& folder, const KernelOptions& options) {
  const dem::Agglomerates& put_in = *from.understood->dem_case.agglomerates;
  ResolvedCase one;
  one.name = from.name;
  one.spheres = put_in.spheres;
  one.sphere_volume = kPi / 6.0 * std::pow(put_in.sphere_diameter, 3);
  one.seed = from.understood->dem_case.seed;
  for (const json::Value& value : from.values) one.values.push_back(text_of(value));
  const fs::path file = folder / "fragments.jsonl";
  GRANARY_TRY(const auto lines, json::LineReader(file).next());
  GRANARY_TRY(one.history, estimation::history_of(lines, file.string()));
  std::erase_if(one.history, [&](const estimation::FragmentSample& sample) { return sample.time < options.from; });
  if (!one.history.empty()) one.history.front().splits.clear();  // they came before
  one.records = estimation::records_of(one.history, estimation::size_bounds(one.spheres));
  one.trained = !is_held_out(one, options.held_out);
  return one;
}

bool broke(const ResolvedCase& one) {
  return std::any_of(one.records.begin(), one.records.end(),
                     [](const estimation::SizeRecord& record) { return record.all_splits() > 0; });
}

/// The settings that are positive numbers, and of which the trained cases in which anything broke have several.
std::vector<std::size_t> conditions(const Campaign& campaign, const std::vector<ResolvedCase>& cases) {
  std::vector<std::size_t> known;
  for (std::size_t k = 0; k < campaign.sweep.settings.size(); ++k) {
    if (is_seed(campaign.sweep.settings[k].pointer)) continue;
    std::set<double> values;
    bool numbers = true;
    for (const ResolvedCase& one : cases) {
      const auto value = leading_number(one.values[k]);
      numbers = numbers && value && *value > 0.0;
      if (value && one.trained && broke(one)) values.insert(*value);
    }
    if (numbers && values.size() > 1) known.push_back(k);
  }
  return known;
}

std::vector<double> features_of(double size, int spheres, const std::vector<double>& ln_setting) {
  const double ln = std::log(size / spheres);
  std::vector<double> features{1.0, ln, ln * ln};
  features.insert(features.end(), ln_setting.begin(), ln_setting.end());
  return features;
}

long splits_by(const estimation::SizeRecord& record, const std::set<std::string>& causes) {
  long n = 0;
  for (const auto& [cause, splits] : record.splits)
    if (causes.count(cause) == 1) n += splits;
  return n;
}

Result<estimation::SelectionLaw> law_of(const std::vector<ResolvedCase>& cases, const std::set<std::string>& causes) {
  std::vector<estimation::CountedEvents> counts;
  for (const ResolvedCase& one : cases)
    for (const estimation::SizeRecord& record : one.records)
      if (one.trained && record.exposure > 0.0)
        counts.push_back({features_of(record.mean_size, one.spheres, one.ln_setting), record.exposure,
                          static_cast<double>(splits_by(record, causes))});
  return estimation::fit_selection_law(counts, kPrior);
}

/// Causes by name, those with too few splits together as "others".
std::map<std::string, std::set<std::string>> groups_of(const std::vector<ResolvedCase>& cases,
                                                       std::map<std::string, long>& splits) {
  std::map<std::string, long> all;
  for (const ResolvedCase& one : cases)
    for (const estimation::SizeRecord& record : one.records)
      for (const auto& [cause, n] : record.splits)
        if (one.trained) all[cause] += n;
  std::map<std::string, std::set<std::string>> groups;
  for (const auto& [cause, n] : all) {
    const std::string group = n >= kEnoughForALaw ? cause : "others";
    groups[group].insert(cause);
    splits[group] += n;
  }
  return groups;
}

json::Value rate_json(const estimation::Rate& rate) {
  return json::Value(json::Array{rate.value, rate.low, rate.high});
}

}  // namespace

estimation::Rate BreakageKernel::rate(double size, const std::vector<double>& ln_setting) const {
  // The causes' errors are independent: their variances add.
  estimation::Rate sum;
  double below = 0.0, above = 0.0;
  for (const CauseLaw& one : causes) {
    const auto part = one.law.at(features_of(size, spheres, ln_setting));
    sum.value += part.value;
    below += std::pow(part.value - part.low, 2);
    above += std::pow(part.high - part.value, 2);
  }
  sum.low = std::max(0.0, sum.value - std::sqrt(below));
  sum.high = sum.value + std::sqrt(above);
  return sum;
}

pbm::BreakageTable BreakageKernel::table(const ResolvedCase& one) const {
  pbm::BreakageTable table;
  std::size_t nearest = 0;
  while (nearest + 1 < daughters.size() && daughters[nearest].empty()) ++nearest;
  for (std::size_t c = 0; c + 1 < bounds.size(); ++c) {
    if (!daughters[c].empty()) nearest = c;
    const double size = std::sqrt(static_cast<double>(bounds[c]) * (bounds[c + 1] - 1));
    table.solid.push_back(size * one.sphere_volume);
    table.rate.push_back(rate(size, one.ln_setting).value);
    table.daughters.emplace_back();
    for (const estimation::MeanDaughter& daughter : daughters[nearest])
      table.daughters.back().push_back({daughter.share, daughter.number});
  }
  return table;
}

Result<std::vector<ResolvedCase>> resolved_cases(const Campaign& campaign, const fs::path& dir,
                                                 const KernelOptions& options, std::vector<std::string>& settings) {
  if (campaign.kind != campaign::Kind::sweep || campaign.sweep.solver != Sweep::Solver::dem)
    return Error{dir.string() + ": this is no sweep of a DEM with agglomerates."};
  std::vector<ResolvedCase> cases;
  for (const SweepCase& from : campaign.sweep.cases) {
    GRANARY_TRY(ResolvedCase one, read_resolved(from, dir / folder_of(from), options));
    if (one.history.size() > 1) cases.push_back(std::move(one));
  }
  if (cases.empty()) return Error{dir.string() + ": no case has fragments yet. Run it: granary resume " + dir.string()};
  for (const ResolvedCase& one : cases)
    if (one.spheres != cases.front().spheres)
      return Error{
          fmt::format("{}: case {} has agglomerates of {} spheres, case {} of {}: one kernel cannot be both's.",
                      dir.string(), cases.front().name, cases.front().spheres, one.name, one.spheres)};
  settings.clear();
  for (const std::size_t k : conditions(campaign, cases)) {
    settings.push_back(campaign.sweep.settings[k].name);
    for (ResolvedCase& one : cases) one.ln_setting.push_back(std::log(*leading_number(one.values[k])));
  }
  return cases;
}

Result<BreakageKernel> fit_kernel(const std::vector<ResolvedCase>& cases, const std::vector<std::string>& settings) {
  BreakageKernel kernel;
  kernel.settings = settings;
  kernel.spheres = cases.front().spheres;
  kernel.bounds = estimation::size_bounds(kernel.spheres);
  std::map<std::string, long> splits;
  for (const auto& [group, causes] : groups_of(cases, splits)) {
    GRANARY_TRY(auto law, law_of(cases, causes));
    kernel.causes.push_back({group, splits[group], std::move(law)});
  }
  if (kernel.causes.empty()) return Error{"nothing broke in the cases that were to be fitted."};
  std::vector<estimation::Split> all;
  for (const ResolvedCase& one : cases)
    for (const estimation::FragmentSample& sample : one.history)
      if (one.trained) all.insert(all.end(), sample.splits.begin(), sample.splits.end());
  for (std::size_t c = 0; c + 1 < kernel.bounds.size(); ++c) {
    const int from = kernel.bounds[c], to = kernel.bounds[c + 1] - 1;
    kernel.daughters.push_back(estimation::mean_daughters(all, from, to));
    kernel.splits.push_back(std::count_if(
        all.begin(), all.end(), [&](const estimation::Split& one) { return one.parent >= from && one.parent <= to; }));
  }
  return kernel;
}

json::Value to_json(const BreakageKernel& kernel) {
  json::Value causes = json::Value::array();
  for (const BreakageKernel::CauseLaw& one : kernel.causes) {
    std::vector<double> error;
    for (std::size_t j = 0; j < one.law.coefficient.size(); ++j) error.push_back(std::sqrt(one.law.covariance[j][j]));
    causes.push(json::Value::object({{"cause", one.cause},
                                     {"splits", static_cast<std::int64_t>(one.splits)},
                                     {"coefficients", one.law.coefficient},
                                     {"standard_errors", error},
                                     {"dispersion", one.law.dispersion}}));
  }
  std::vector<std::string> features{"1", fmt::format("ln(spheres/{})", kernel.spheres),
                                    fmt::format("ln^2(spheres/{})", kernel.spheres)};
  for (const std::string& setting : kernel.settings) features.push_back("ln(" + setting + ")");
  return json::Value::object({{"format", "granary-breakage-law-1"},
                              {"features", features},
                              {"spheres", kernel.spheres},
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
         {"rate_1_s", rate_json(kernel.rate(std::sqrt(static_cast<double>(record.from) * record.to), one.ln_setting))},
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
