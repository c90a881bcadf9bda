#include "controller/bench/dem_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/files.hpp"
#include "pilot/launch/draw_svg.hpp"

namespace granary::bench {
namespace {

using json::Value;

constexpr const char* kStyle = R"(set encoding utf8
set terminal svg noenhanced size 980,{} dynamic font 'system-ui,sans-serif,14' background '#ffffff'
set border 3 lc rgb '#94a3b8' lw 1
set tics out nomirror scale 0.5 textcolor rgb '#334155'
set grid xtics ytics lt 1 lw 0.6 lc rgb '#e2e8f0'
)";

struct Look {
  const char *choice, *colour;
  int point;
};
constexpr std::array<Look, 4> kLooks{{{"time step", "#1d4ed8", 7},
                                      {"stiffness", "#ea580c", 5},
                                      {"skin", "#16a34a", 9},
                                      {"coarse graining", "#9333ea", 13}}};

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

std::string choices_script(const Value& rows) {
  std::string script = fmt::format(kStyle, 480), plots[2];
  script +=
      "set multiplot layout 1,2\nset logscale x\nset xlabel 'core seconds for a second of process'\n"
      "set xzeroaxis lc rgb '#64748b' lw 1.2\nset key outside bottom center horizontal\n";
  const char *keys[2] = {"collision_rate", "impact_speed"}, *titles[2] = {"Collision rate", "Impact speed"};
  for (int k = 0; k < 2; ++k) {
    for (const Look& look : kLooks) {
      const std::string data = data_of(rows, look.choice, keys[k]);
      if (data.empty()) continue;
      const std::string block = fmt::format("${}_{}", keys[k], look.point);
      script += fmt::format("{} << EOD\n{}EOD\n", block, data);
      plots[k] += fmt::format("{}{} using 1:2:3 with yerrorlines lw 1.6 pt {} ps 0.7 lc rgb '{}' title '{}'",
                              plots[k].empty() ? "plot " : ", \\\n     ", block, look.point, look.colour, look.choice);
      // Only what stands apart is named: skins all lie on one point's error.
      if (look.choice != std::string_view("skin"))
        plots[k] +=
            fmt::format(", \\\n     {} using 1:2:4 with labels font ',11' offset 0,0.9 textcolor rgb '{}' notitle",
                        block, look.colour);
    }
    script += fmt::format("set ylabel 'difference from the reference [%]'\nset title '{}'\n{}\n", titles[k], plots[k]);
  }
  return script + "unset multiplot\nunset output\n";
}

std::string speed_script(const Value& rows) {
  std::string data;
  for (const Value& row : rows.items())
    data += fmt::format("\"{}{}\" {} {} \"{:.1f}x\"\n", row.text_or("case", ""),
                        row.integer_or("ranks", 1) > 1 ? fmt::format(", {} ranks", row.integer_or("ranks", 1)) : "",
                        row.number_or("stock_ms_per_step", 0.0), row.number_or("granary_ms_per_step", 0.0),
                        row.number_or("ratio", 0.0));
  return fmt::format(kStyle, 420) +
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
