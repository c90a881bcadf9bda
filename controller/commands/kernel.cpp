#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/commands/commands.hpp"
#include "controller/sweep/kernel_files.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

namespace {

/// Mean over cases of the mean errors; NaN if there is none.
double mean_error(const std::vector<sweep::ResolvedCase>& cases, const std::vector<sweep::Comparison>& comparisons,
                  bool trained) {
  double sum = 0.0;
  int n = 0;
  for (std::size_t i = 0; i < cases.size(); ++i)
    if (cases[i].trained == trained) sum += comparisons[i].mean_error(), ++n;
  return sum / n;
}

json::Value as_json(const sweep::BreakageKernel& kernel, const std::vector<sweep::ResolvedCase>& cases,
                    const std::vector<sweep::Comparison>& comparisons, const fs::path& folder) {
  json::Value list = json::Value::array();
  for (std::size_t i = 0; i < cases.size(); ++i)
    list.push(json::Value::object({{"case", cases[i].name},
                                   {"settings", cases[i].values},
                                   {"fitted", cases[i].trained},
                                   {"dem_d50_m", comparisons[i].dem_d50.back()},
                                   {"pbm_d50_m", comparisons[i].pbm_d50.back()},
                                   {"mean_error", comparisons[i].mean_error()},
                                   {"last_error", comparisons[i].last_error()}}));
  return json::Value::object({{"kernel", sweep::to_json(kernel)},
                              {"mean_error_fitted", mean_error(cases, comparisons, true)},
                              {"mean_error_held_out", mean_error(cases, comparisons, false)},
                              {"cases", std::move(list)},
                              {"folder", folder.string()}});
}

void print(const sweep::BreakageKernel& kernel, const std::vector<sweep::ResolvedCase>& cases,
           const std::vector<sweep::Comparison>& comparisons, const fs::path& folder) {
  fmt::print("ln rate = sum of coefficients, with their 95 %, times {}\n", fmt::join(features_of(kernel), ", "));
  for (const auto& one : kernel.causes) {
    fmt::print("  {:<10} {:>6} splits, dispersion {:5.2f}:", one.cause, one.splits, one.law.dispersion);
    for (std::size_t j = 0; j < one.law.coefficient.size(); ++j)
      fmt::print("  {:.2f} ({:.2f} to {:.2f})", one.law.coefficient[j], one.interval(j).first, one.interval(j).second);
    fmt::print("\n");
  }
  fmt::print(
      "case   settings                        d50 at the end: DEM      PBM        error over time, at the end\n");
  for (std::size_t i = 0; i < cases.size(); ++i)
    fmt::print("{}   {:<30} {:>10.3f} mm {:>10.3f} mm   {:>8.1f} %  {:>+8.1f} %  {}\n", cases[i].name,
               fmt::format("{}", fmt::join(cases[i].values, ", ")), 1e3 * comparisons[i].dem_d50.back(),
               1e3 * comparisons[i].pbm_d50.back(), 100.0 * comparisons[i].mean_error(),
               100.0 * comparisons[i].last_error(), cases[i].trained ? "" : "held out");
  fmt::print("d50 over time: mean error {:.1f} % of the fitted cases", 100.0 * mean_error(cases, comparisons, true));
  if (const double held_out = mean_error(cases, comparisons, false); std::isfinite(held_out))
    fmt::print(", {:.1f} % of those held out", 100.0 * held_out);
  fmt::print("\n{}\n", folder.string());
}

}  // namespace

Result<Exit> kernel(const KernelCommand& command) {
  const fs::path dir = fs::absolute(command.dir).lexically_normal();
  GRANARY_TRY(const campaign::Campaign campaign, campaign::read_written_campaign(dir / "campaign.json"));
  std::vector<std::string> settings;
  GRANARY_TRY(const auto cases, sweep::resolved_cases(campaign, dir, {command.held_out, command.from}, settings));
  const auto by = command.by_impacts ? sweep::KernelOptions::By::impacts : sweep::KernelOptions::By::settings;
  GRANARY_TRY(const auto kernel, sweep::fit_kernel(cases, settings, by));
  const fs::path folder = dir / "kernel";
  std::vector<sweep::Comparison> comparisons;
  for (const sweep::ResolvedCase& one : cases) {
    GRANARY_TRY(auto comparison, sweep::compare(kernel, one, folder / one.name, program_folder()));
    comparisons.push_back(std::move(comparison));
  }
  GRANARY_CHECK(sweep::write_kernel(kernel, cases, comparisons, folder));
  if (command.json)
    fmt::print("{}\n", json::dump(as_json(kernel, cases, comparisons, folder), 1));
  else
    print(kernel, cases, comparisons, folder);
  return Exit::ok;
}

}  // namespace granary::commands
