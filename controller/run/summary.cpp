#include "controller/run/summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace granary::run {
namespace fs = std::filesystem;
namespace {

double wall_of(const CampaignResults& results, const std::string& kind) {
  for (const KindUse& use : results.core_use.kinds)
    if (use.kind == kind) return use.wall;
  return 0.0;
}

std::int64_t count_of(const CampaignResults& results, const std::string& kind) {
  return std::count_if(results.bursts.begin(), results.bursts.end(),
                       [&](const BurstSummary& burst) { return burst.kind == kind; });
}

std::string or_dash(double value, const char* format) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

/// "0-3,6" instead of "0, 1, 2, 3, 6".
std::string ranges(std::vector<int> cores) {
  if (cores.empty()) return "none";
  std::sort(cores.begin(), cores.end());
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < cores.size();) {
    std::size_t last = i;
    while (last + 1 < cores.size() && cores[last + 1] == cores[last] + 1) ++last;
    parts.push_back(last == i ? fmt::format("{}", cores[i]) : fmt::format("{}-{}", cores[i], cores[last]));
    i = last + 1;
  }
  return fmt::format("{}", fmt::join(parts, ","));
}

}  // namespace

json::Value summary_json(const CampaignResults& results, const fs::path& results_h5, const fs::path& report) {
  json::Value bursts = json::Value::array();
  for (const BurstSummary& burst : results.bursts) {
    bursts.push(json::Value::object({{"kind", burst.kind},
                                     {"number", burst.number},
                                     {"reason", burst.reason},
                                     {"process_time_s", burst.process_end},
                                     {"dem_time_s", burst.dem_end},
                                     {"wall_s", burst.wall},
                                     {"cores", burst.cores},
                                     {"coarse_graining", burst.coarse_graining},
                                     {"dem_particles", burst.dem_particles},
                                     {"d50_m", burst.d50},
                                     {"particles", burst.particles}}));
  }
  json::Value summary = json::Value::object({{"ended", results.ended},
                                             {"message", results.message},
                                             {"dem_bursts", count_of(results, "dem")},
                                             {"pbm_bursts", count_of(results, "pbm")},
                                             {"dem_s", wall_of(results, "dem")},
                                             {"pbm_s", wall_of(results, "pbm")},
                                             {"estimation_s", wall_of(results, "estimation")},
                                             {"idle_s", results.core_use.idle},
                                             {"wall_s", results.core_use.wall},
                                             {"core_use", results.core_use.busy_share},
                                             {"bursts", std::move(bursts)}});
  summary.set("results", results_h5.string()).set("report", report.string());
  return summary;
}

std::string summary_text(const CampaignResults& results, const fs::path& results_h5, const fs::path& report) {
  std::string text = fmt::format("{} ended {}: {}\n\n", results.provenance.name, results.ended, results.message);
  text += fmt::format("{:>5} {:>4} {:>10} {:>9} {:>8} {:>9} {:>11} {:>9}  {}\n", "burst", "kind", "process s", "DEM s",
                      "wall s", "d50 um", "particles", "DEM part.", "why it ended");
  for (const BurstSummary& burst : results.bursts) {
    text += fmt::format("{:>5} {:>4} {:>10} {:>9} {:>8.2f} {:>9} {:>11} {:>9}  {}\n", burst.number, burst.kind,
                        or_dash(burst.process_end, "{:.2f}"), or_dash(burst.dem_end, "{:.3f}"), burst.wall,
                        or_dash(burst.d50 * 1e6, "{:.1f}"), or_dash(burst.particles, "{:.3e}"),
                        or_dash(burst.dem_particles, "{:.0f}"), burst.reason);
  }
  const CoreUse& use = results.core_use;
  text += fmt::format(
      "\n{} DEM bursts in {:.1f} s, {} PBM bursts in {:.1f} s, idle {:.1f} s, whole campaign {:.1f} s; {} cores, core "
      "use {:.0f} %\n",
      count_of(results, "dem"), wall_of(results, "dem"), count_of(results, "pbm"), wall_of(results, "pbm"), use.idle,
      use.wall, use.cores, 100.0 * use.busy_share);
  if (!results_h5.empty()) text += fmt::format("results: {}\n", results_h5.string());
  if (!report.empty()) text += fmt::format("report:  {}\n", report.string());
  return text;
}

std::string timeline_text(const std::vector<pilot::Interval>& timeline, const pilot::Usage& usage) {
  std::string text = fmt::format("{:>10} {:>10}  {:<24} {}\n", "start s", "end s", "task", "cores");
  for (const pilot::Interval& interval : timeline)
    text += fmt::format("{:>10.2f} {:>10.2f}  {:<24} {}\n", interval.start, interval.end, interval.name,
                        ranges(interval.cores));
  text += fmt::format("core use {:.1f} % ({:.1f} of {:.1f} core seconds)\n",
                      usage.total > 0.0 ? 100.0 * usage.busy / usage.total : 0.0, usage.busy, usage.total);
  return text;
}

json::Value timeline_json(const std::vector<pilot::Interval>& timeline) {
  json::Value list = json::Value::array();
  for (const pilot::Interval& interval : timeline) {
    json::Value cores = json::Value::array();
    for (const int core : interval.cores) cores.push(core);
    list.push(json::Value::object({{"task", interval.name},
                                   {"attempt", interval.attempt},
                                   {"cores", std::move(cores)},
                                   {"start_s", interval.start},
                                   {"end_s", interval.end}}));
  }
  return list;
}

}  // namespace granary::run
