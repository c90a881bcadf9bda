#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "controller/report/figures.hpp"
#include "controller/report/script.hpp"

namespace granary::report {
namespace {

constexpr std::string_view kKinds[] = {"dem", "pbm", "estimation", "other", "monitor"};
constexpr const char* kNothingRan = "no task ran";

std::string_view drawn_kind(std::string_view kind) {
  return std::find(std::begin(kKinds), std::end(kKinds), kind) == std::end(kKinds) ? "other" : kind;
}

std::string kind_title(std::string_view kind) {
  if (kind == "dem") return "DEM";
  if (kind == "pbm") return "PBM";
  return std::string(kind);
}

/// A stretch of time on one row of the chart.
struct Box {
  double start, end;
};

/// Neighbours with less than `gap` between them become one: thousands of short tasks look the same, and the page stays
/// small.
std::vector<Box> merged(std::vector<Box> boxes, double gap) {
  std::sort(boxes.begin(), boxes.end(), [](const Box& a, const Box& b) { return a.start < b.start; });
  std::vector<Box> out;
  for (const auto& box : boxes) {
    if (!out.empty() && box.start - out.back().end < gap)
      out.back().end = std::max(out.back().end, box.end);
    else
      out.push_back(box);
  }
  return out;
}

double last_end(const CampaignResults& results) {
  double wall = results.core_use.wall;
  for (const auto& entry : results.timeline) wall = std::max(wall, entry.end);
  return wall;
}

std::int64_t n_cores(const CampaignResults& results) {
  std::int64_t n = results.core_use.cores;
  for (const auto& entry : results.timeline)
    for (const auto core : entry.cores) n = std::max(n, core + 1);
  return n;
}

/// Cores from below upwards, monitors (which occupy no core) in a row of their own below them.
Figure gantt(const CampaignResults& results) {
  Figure figure{"Cores over time",
                "Each core of the allocation from the start of the campaign; monitors occupy no core.",
                {"gantt", 1260, 0, ""},
                kNothingRan};
  const double wall = last_end(results);
  const auto cores = n_cores(results);
  if (results.timeline.empty() || !(wall > 0.0)) return figure;

  std::map<std::string_view, std::map<std::int64_t, std::vector<Box>>> boxes;  // kind -> row -> stretches
  for (const auto& entry : results.timeline) {
    const auto kind = drawn_kind(entry.kind);
    for (const auto core : entry.cores) boxes[kind][core].push_back({entry.start, entry.end});
    if (entry.cores.empty()) boxes[kind][-1].push_back({entry.start, entry.end});
  }

  std::string script;
  std::vector<std::string> draws;
  bool any_without_core = false;
  for (const auto kind : kKinds) {
    if (!boxes.contains(kind)) continue;
    std::vector<double> start, end, row, half;
    for (auto& [core, list] : boxes[kind])
      for (const auto& box : merged(std::move(list), wall / 2500.0)) {
        start.push_back(box.start);
        end.push_back(box.end);
        row.push_back(static_cast<double>(core));
        half.push_back(core < 0 ? 0.2 : 0.4);
        any_without_core |= core < 0;
      }
    script += data_block(kind, {start, end, row, half});
    draws.push_back(fmt::format(
        "${0} using (0.5*($1+$2)):3:1:2:($3-$4):($3+$4) with boxxyerror fs solid 0.9 noborder lc rgb '{1}' title '{2}'",
        kind, kind_colour(kind), kind_title(kind)));
  }

  std::vector<std::string> tics;
  const std::int64_t every = std::max<std::int64_t>(1, (cores + 23) / 24);
  for (std::int64_t core = 0; core < cores; core += every) tics.push_back(fmt::format("'core {0}' {0}", core));
  if (any_without_core) tics.push_back("'no core' -1");
  const double lowest = any_without_core ? -1.6 : -0.6;
  script += fmt::format(
      "set ytics ({})\nset yrange [{}:{}]\nset xrange [0:{:.7g}]\nset xlabel 'wall time [s]'\nunset grid\nset grid "
      "xtics\n",
      fmt::join(tics, ", "), lowest, static_cast<double>(cores) - 0.4, wall);
  figure.plot.script = script + fmt::format("plot {}\n", fmt::join(draws, ", \\\n     "));
  figure.plot.height = static_cast<int>(std::clamp<std::int64_t>(130 + 26 * (cores + 1), 190, 640));
  return figure;
}

/// Mean number of busy cores of each kind in each of n equal slices of the wall time, one kind upon the other.
Figure busy_cores(const CampaignResults& results) {
  Figure figure{"Busy cores",
                "Cores occupied by each kind of task, one upon the other. Dashed: the allocation.",
                {"busy-cores", 1260, 240, ""},
                kNothingRan};
  const double wall = last_end(results);
  const auto cores = n_cores(results);
  if (results.timeline.empty() || !(wall > 0.0) || cores == 0) return figure;

  constexpr std::size_t kSlices = 400;
  const double width = wall / kSlices;
  std::vector<double> from;
  for (std::size_t i = 0; i < kSlices; ++i) from.push_back(width * static_cast<double>(i));
  // Each slice is drawn from its start to its end: a core is busy or not, there are no slopes.
  const auto twice = [](const std::vector<double>& values) {
    std::vector<double> out;
    for (const double value : values) out.insert(out.end(), 2, value);
    return out;
  };
  std::vector<double> steps = twice(from), below(kSlices, 0.0);
  for (std::size_t i = 1; i < steps.size(); i += 2) steps[i] += width;
  std::vector<std::vector<double>> columns{steps, twice(below)};
  std::vector<std::string> draws;
  for (const auto kind : kKinds) {
    std::vector<double> top = below;
    bool any = false;
    for (const auto& entry : results.timeline) {
      if (drawn_kind(entry.kind) != kind || entry.cores.empty()) continue;
      any = true;
      for (auto i = static_cast<std::size_t>(std::max(0.0, entry.start / width)); i < kSlices && from[i] < entry.end;
           ++i)
        top[i] += static_cast<double>(entry.cores.size()) *
                  std::max(0.0, std::min(entry.end, from[i] + width) - std::max(entry.start, from[i])) / width;
    }
    if (!any) continue;
    columns.push_back(twice(top));
    below = std::move(top);
    draws.push_back(fmt::format("$data using 1:{}:{} with filledcurves fs solid 0.9 noborder lc rgb '{}' title '{}'",
                                columns.size() - 1, columns.size(), kind_colour(kind), kind_title(kind)));
  }
  if (draws.empty()) return figure;
  figure.plot.script =
      data_block("data", columns) +
      fmt::format(
          "set xlabel 'wall time [s]'\nset ylabel 'cores [–]'\nset xrange [0:{:.7g}]\nset yrange [0:{:.7g}]\n"
          "plot {}, \\\n     {} with lines dt 2 lw 1.5 lc rgb '#1e293b' title 'allocation'\n",
          wall, 1.15 * static_cast<double>(cores), fmt::join(draws, ", \\\n     "), cores);
  return figure;
}

}  // namespace

std::vector<Figure> core_figures(const CampaignResults& results) { return {gantt(results), busy_cores(results)}; }

}  // namespace granary::report
