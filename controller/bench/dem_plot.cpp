#include "controller/bench/dem_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/files.hpp"
#include "controller/bench/plot_style.hpp"
#include "pilot/launch/draw_svg.hpp"

namespace granary::bench {
namespace {

using json::Value;

constexpr const char* kGrid = "set grid xtics ytics lt 1 lw 0.6 lc rgb '#e2e8f0'\n";

struct Look {
  const char *choice, *colour;
  int point;
  int row;             ///< of the picture: what moves little above, what moves much below
  const char* offset;  ///< of the values written beside the points
};
constexpr std::array<Look, 4> kLooks{{{"time step", "#1d4ed8", 7, 0, "0,-1.6"},
                                      {"stiffness", "#ea580c", 5, 0, "0,1.6"},
                                      {"skin", "#16a34a", 9, 0, ""},
                                      {"coarse graining", "#9333ea", 13, 1, "0,1.3"}}};
struct Panel {
  const char *key, *title;
};
constexpr std::array<Panel, 2> kPanels{{{"collision_rate", "Collision rate"}, {"impact_speed", "Impact speed"}}};

/// Cost, error and statistical error [%] of each setting of a choice.
std::string data_of(const Value& rows, const std::string& choice, const std::string& key) {
  std::string data;
  for (const Value& row : rows.items())
    if (row.text_or("choice", "") == choice)
      data += fmt::format("{} {} {} \"{}\"\n", row.number_or("core_s_per_process_s", 0.0),
                          100.0 * row.number_or(key + "_error", 0.0),
                          100.0 * row.number_or(key + "_statistical_error", 0.0),
                          row.text_or("value", "").substr(0, row.text_or("value", "").find(',')));
  return data;
}

/// One panel: every choice of that row of the picture, as points with their statistical errors.
std::string panel_script(const Value& rows, const Panel& panel, int row) {
  std::string blocks, plots;
  for (const Look& look : kLooks) {
    const std::string data = data_of(rows, look.choice, panel.key);
    if (look.row != row || data.empty()) continue;
    const std::string block = fmt::format("${}_{}", panel.key, look.point);
    blocks += fmt::format("{} << EOD\n{}EOD\n", block, data);
    plots += fmt::format("{}{} using 1:2:3 with yerrorbars lw 1.4 pt {} ps 0.7 lc rgb '{}' title '{}'",
                         plots.empty() ? "plot " : ", \\\n     ", block, look.point, look.colour, look.choice);
    // Skins have one physics, and need no names.
    if (*look.offset != '\0')
      plots += fmt::format(
          ", \\\n     {} using 1:2:4 with labels font ',10' rotate by 35 offset {} textcolor rgb '{}' notitle", block,
          look.offset, look.colour);
  }
  return blocks + fmt::format("set title '{}'\n{}\n", panel.title, plots);
}

std::string choices_script(const Value& rows) {
  std::string script = plot_style(980, 860, 14) + kGrid;
  script +=
      "set multiplot layout 2,2\nset logscale x\nset xrange [5:300]\nset xlabel 'core seconds for a second of "
      "process'\n"
      "set xzeroaxis lc rgb '#64748b' lw 1.2\nset key outside bottom center horizontal\n"
      "set ylabel 'difference from the reference [%]'\n";
  for (const int row : {0, 1}) {
    script += row == 0 ? "set yrange [-40:40]\n" : "set yrange [-90:30]\n";
    for (const Panel& panel : kPanels) script += panel_script(rows, panel, row);
  }
  return script + "unset multiplot\nunset output\n";
}

std::string speed_script(const Value& rows) {
  std::string data;
  for (const Value& row : rows.items())
    data += fmt::format("\"{}{}\" {} {} \"{}\"\n", row.text_or("case", ""),
                        row.integer_or("ranks", 1) > 1 ? fmt::format(", {} ranks", row.integer_or("ranks", 1)) : "",
                        row.number_or("stock_ms_per_step", 0.0), row.number_or("granary_ms_per_step", 0.0),
                        row["ratio"].is_number() ? fmt::format("{:.1f}x", row.number_or("ratio", 0.0)) : "stock fails");
  return plot_style(980, 420, 14) + kGrid +
         fmt::format(
             "$speed << EOD\n{}EOD\n"
             "set logscale y\nset ylabel 'ms a step'\nset yrange [0.05:*]\nset style fill solid 0.9 noborder\n"
             "set boxwidth 0.35\nset key top left\nset xtics font ',11'\nset xrange [-0.6:{}]\n"
             "plot $speed using ($0-0.19):2:xtic(1) with boxes lc rgb '#ea580c' title 'stock LIGGGHTS, best skin', \\\n"
             "     $speed using ($0+0.19):3 with boxes lc rgb '#1d4ed8' title 'granary-dem', \\\n"
             "     $speed using ($0+0.19):3:4 with labels offset 0,0.7 textcolor rgb '#1d4ed8' notitle\nunset output\n",
             data, static_cast<double>(rows.size()) - 0.4);
}

}  // namespace

Status draw_dem(const Value& document, const std::filesystem::path& folder) {
  GRANARY_CHECK(make_folders(folder));
  if (document["choices"].size() > 0)
    GRANARY_CHECK(pilot::draw_svg(choices_script(document["choices"]), folder / "dem_choices.svg"));
  if (document["speed"].size() > 0)
    GRANARY_CHECK(pilot::draw_svg(speed_script(document["speed"]), folder / "dem_speed.svg"));
  return {};
}

}  // namespace granary::bench
