#include <algorithm>
#include <iterator>
#include <map>
#include <string_view>
#include <utility>

#include "common/results/campaign_results.hpp"

namespace granary {
namespace {

using Interval = std::pair<double, double>;  // start, end [s]

constexpr std::string_view kKinds[] = {"dem", "pbm", "monitor", "estimation", "other"};

std::string_view known(std::string_view kind) {
  return std::find(std::begin(kKinds), std::end(kKinds), kind) == std::end(kKinds) ? "other" : kind;
}

/// Total length of the union of intervals.
double covered(std::vector<Interval> intervals) {
  std::sort(intervals.begin(), intervals.end());
  double total = 0.0, reached = -1e300;
  for (const auto& [start, end] : intervals) {
    total += std::max(0.0, end - std::max(start, reached));
    reached = std::max(reached, end);
  }
  return total;
}

}  // namespace

CoreUse core_use(const std::vector<TimelineEntry>& timeline, std::int64_t cores, double wall) {
  CoreUse use{cores, wall, 0.0, 0.0, {}};

  std::vector<Interval> occupied;
  std::map<std::int64_t, std::vector<Interval>> by_core;
  for (const auto& entry : timeline) {
    if (!entry.cores.empty()) occupied.emplace_back(entry.start, entry.end);
    for (const auto core : entry.cores) by_core[core].emplace_back(entry.start, entry.end);
  }
  for (const auto kind : kKinds) {
    std::vector<Interval> ran;
    double core_seconds = 0.0;
    for (const auto& entry : timeline) {
      if (kind != known(entry.kind)) continue;
      ran.emplace_back(entry.start, entry.end);
      core_seconds += static_cast<double>(entry.cores.size()) * (entry.end - entry.start);
    }
    if (!ran.empty()) use.kinds.push_back({std::string(kind), covered(std::move(ran)), core_seconds});
  }

  use.idle = std::max(0.0, wall - covered(std::move(occupied)));
  double busy = 0.0;
  for (auto& [core, intervals] : by_core) busy += covered(std::move(intervals));
  if (cores > 0 && wall > 0.0) use.busy_share = busy / (static_cast<double>(cores) * wall);
  return use;
}

}  // namespace granary
