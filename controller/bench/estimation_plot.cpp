#include "controller/bench/estimation_plot.hpp"

#include <fmt/format.h>

#include <cmath>

#include "controller/bench/plot_style.hpp"
#include "estimation/search/search.hpp"
#include "pilot/launch/draw_svg.hpp"

namespace granary::bench {
namespace {

using json::Value;

constexpr const char* kAxes = R"(set grid ytics lt 1 lw 0.6 lc rgb '#e2e8f0'
set xlabel 'parameters' textcolor rgb '#334155'
set xrange [1:7]
set xtics (2, 4, 6)
set multiplot layout 1,2
)";
constexpr const char* kShares = R"(set title 'truth in the 95 % interval' textcolor rgb '#0f172a'
set object rectangle from 1,90 to 7,99 fc rgb '#dcfce7' fs solid noborder behind
set yrange [60:102]
set ytics ('60 %%' 60, '70 %%' 70, '80 %%' 80, '90 %%' 90, '95 %%' 95, '100 %%' 100)
unset key
)";
constexpr const char* kCosts = R"(
unset object
set title 'evaluations to the end of the search, median' textcolor rgb '#0f172a'
set logscale y
set yrange [20:4000]
set ytics (30, 100, 300, 1000, 3000)
set key outside right center Left reverse samplen 2 spacing 1.3 textcolor rgb '#334155'
)";
constexpr const char* kColours[] = {"#1d4ed8", "#ea580c", "#16a34a", "#9333ea", "#64748b"};

}  // namespace

std::string twins_script(const Value& document) {
  std::string data, shares, costs;
  int method = 0;
  for (const estimation::Method each : estimation::kMethods) {
    std::string rows;
    for (const Value& row : document["methods"].items_or_none()) {
      if (row.text_or("name", "") != estimation::name_of(each)) continue;
      const double share = row.number_or("recovered_share", 0.0), n = row.number_or("parameters", 0.0);
      // Of intervals that hold it in 95 % of cases, as if those of one problem were independent.
      const double scatter = std::sqrt(0.95 * 0.05 / (n * row.number_or("seeds", 1.0)));
      rows += fmt::format("{} {} {} {}\n", n + 0.16 * (method - 2), 100.0 * share, 100.0 * scatter,
                          row.number_or("evaluations_median", 0.0));
    }
    if (!rows.empty()) {
      data += fmt::format("$m{} << EOD\n{}EOD\n", method, rows);
      shares += fmt::format("{}$m{} using 1:2:3 with yerrorbars pt 7 ps 0.8 lw 1.5 lc rgb '{}'",
                            shares.empty() ? "plot " : ", \\\n     ", method, kColours[method]);
      costs +=
          fmt::format("{}$m{} using 1:4 with linespoints pt 7 ps 0.8 lw 1.5 lc rgb '{}' title '{}'",
                      costs.empty() ? "plot " : ", \\\n     ", method, kColours[method], estimation::name_of(each));
    }
    ++method;
  }
  return plot_style(1000, 430, 14) + kAxes + data + kShares + shares + kCosts + costs +
         "\nunset multiplot\nunset output\n";
}

Status draw_twins(const Value& document, const std::filesystem::path& file) {
  return pilot::draw_svg(twins_script(document), file);
}

}  // namespace granary::bench
