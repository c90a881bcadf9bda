#include "controller/bench/pbm_plot.hpp"

#include <fmt/format.h>

#include <array>
#include <map>

#include "controller/bench/plot_style.hpp"
#include "pilot/launch/draw_svg.hpp"

namespace granary::bench {
namespace {

using json::Value;

constexpr const char* kAxes = R"(set xlabel 'CPU time on one core' textcolor rgb '#334155'
set ylabel 'L1 error of the numbers' textcolor rgb '#334155'
set title 'Aggregation of two solids on n x n classes, against the exact solution' textcolor rgb '#0f172a'
set grid xtics ytics lt 1 lw 0.6 lc rgb '#e2e8f0'
set key inside top right Left reverse samplen 2 spacing 1.3 textcolor rgb '#334155'
set logscale xy
set xtics ('0.1 ms' 1e-4, '1 ms' 1e-3, '10 ms' 1e-2, '0.1 s' 1e-1, '1 s' 1, '10 s' 10, '100 s' 100, '1000 s' 1000)
set ytics ('0.1 %%' 0.1, '0.3 %%' 0.3, '1 %%' 1, '3 %%' 3, '10 %%' 10, '30 %%' 30)
set yrange [0.2:40]
)";

struct Look {
  const char *method, *title, *colour;
  int point;
};
constexpr std::array<Look, 2> kLooks{
    {{"solver", "granary-pbm", "#1d4ed8", 7}, {"reference", "plain reference, explicit Euler", "#ea580c", 5}}};

}  // namespace

std::string work_precision_script(const Value& document) {
  std::string data, labels, plot;
  for (const Look& look : kLooks) {
    std::map<std::int64_t, std::string> curves;  // by bins
    for (const Value& row : document["work_precision"].items_or_none()) {
      if (row.text_or("method", "") != look.method) continue;
      const double cpu = row.number_or("cpu_s", 0.0), error = 100.0 * row.number_or("l1_number", 0.0);
      const std::int64_t bins = row.integer_or("bins", 0);
      if (curves.find(bins) == curves.end())
        labels += fmt::format("set label 'n = {}' at {},{} offset 0,1 left textcolor rgb '{}'\n", bins, cpu, error,
                              look.colour);
      curves[bins] += fmt::format("{} {}\n", cpu, error);
    }
    for (const auto& [bins, points] : curves) {
      data += fmt::format("${}_{} << EOD\n{}EOD\n", look.method, bins, points);
      plot += fmt::format("{}${}_{} with linespoints lw 2 pt {} ps 0.7 lc rgb '{}' {}",
                          plot.empty() ? "plot " : ", \\\n     ", look.method, bins, look.point, look.colour,
                          bins == curves.begin()->first ? fmt::format("title '{}'", look.title) : "notitle");
    }
  }
  return plot_style(860, 520, 15) + kAxes + data + labels + plot + "\nunset output\n";
}

Status draw_work_precision(const Value& document, const std::filesystem::path& file) {
  return pilot::draw_svg(work_precision_script(document), file);
}

}  // namespace granary::bench
