#include "pbm_solver/verification/convergence_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "pilot/launch/draw_svg.hpp"

namespace granary::pbm {
namespace {

constexpr int kWidth = 1180, kPanelHeight = 400;

constexpr std::string_view kColours[] = {"#2563eb", "#dc2626", "#059669", "#d97706", "#7c3aed",
                                         "#0891b2", "#be185d", "#4d7c0f", "#475569"};
constexpr int kMarks[] = {7, 5, 9, 13, 11, 6, 4, 8, 12};

struct Line {
  std::string name;
  std::vector<double> bins, error;  ///< error in %
  double order() const { return std::log(error.front() / error.back()) / std::log(bins.back() / bins.front()); }
};

struct Panel {
  std::string title;
  std::vector<Line> lines;
};

std::vector<Panel> panels_of(std::span<const Verification> results) {
  std::vector<Panel> panels;
  for (const Verification& v : results) {
    if (std::isnan(v.errors.l1_number)) continue;
    if (panels.empty() || panels.back().title != v.group) panels.push_back({v.group, {}});
    std::vector<Line>& lines = panels.back().lines;
    if (std::isnan(v.order)) lines.push_back({v.name, {}, {}});  // the first grid of a case
    lines.back().bins.push_back(v.bins);
    lines.back().error.push_back(100.0 * v.errors.l1_number);
  }
  for (Panel& panel : panels) std::erase_if(panel.lines, [](const Line& line) { return line.bins.size() < 2; });
  std::erase_if(panels, [](const Panel& panel) { return panel.lines.empty(); });
  return panels;
}

std::string data_of(const Line& line) {
  std::string data;
  for (std::size_t k = 0; k < line.bins.size(); ++k) data += fmt::format("{:g} {:.6g}\n", line.bins[k], line.error[k]);
  return data + "e\n";
}

/// A guide of the given slope: through the panel's lower left, below the lines it is compared with.
std::string guide(double slope, double from, double to, double error) {
  return fmt::format("{:g} {:.6g}\n{:g} {:.6g}\ne\n", from, error, to, error * std::pow(from / to, slope));
}

std::string script_of(const Panel& panel, bool two_solids) {
  double low = 1e300, high = 0.0, least = 1e300, most = 0.0;
  for (const Line& line : panel.lines) {
    low = std::min(low, line.bins.front()), high = std::max(high, line.bins.back());
    least = std::min(least, *std::min_element(line.error.begin(), line.error.end()));
    most = std::max(most, *std::max_element(line.error.begin(), line.error.end()));
  }
  std::string script =
      fmt::format("set label 1 '{}' at graph 0,1.07 left font ',14' textcolor rgb '#0f172a'\n", panel.title);
  script += fmt::format("set xlabel 'classes{}'\n", two_solids ? " along each solid" : "");
  script +=
      fmt::format("set xrange [{:g}:{:g}]\nset yrange [{:g}:{:g}]\n", 0.85 * low, 1.15 * high, 0.6 * least, 1.8 * most);
  std::string plot = "plot ", data;
  for (std::size_t k = 0; k < panel.lines.size(); ++k) {
    const Line& line = panel.lines[k];
    plot += fmt::format("'-' with linespoints lc rgb '{}' lw 1.6 pt {} ps 0.6 title '{}  {:.1f}', ",
                        kColours[k % std::size(kColours)], kMarks[k % std::size(kMarks)], line.name, line.order());
    data += data_of(line);
  }
  plot +=
      "'-' with lines dt 2 lc rgb '#94a3b8' title 'slope 1', '-' with lines dt 3 lc rgb '#94a3b8' title 'slope 2'\n";
  data += guide(1.0, low, high, 0.7 * most) + guide(2.0, low, high, 0.7 * most);
  return script + plot + data;
}

}  // namespace

std::string convergence_script(std::span<const Verification> results) {
  const std::vector<Panel> panels = panels_of(results);
  const int columns = std::min<int>(2, static_cast<int>(panels.size()));
  const int rows = (static_cast<int>(panels.size()) + 1) / 2;
  std::string script = fmt::format(
      "set encoding utf8\n"
      "set terminal svg noenhanced size {},{} dynamic background rgb 'white' font 'system-ui,sans-serif,13'\n"
      "set multiplot layout {},{} margins 0.075,0.815,0.08,0.93 spacing 0.25,0.17\n",
      kWidth * columns / 2, kPanelHeight * rows, rows, columns);
  script +=
      "set logscale xy\n"
      "set border 3 lc rgb '#94a3b8' lw 1\n"
      "set tics out nomirror scale 0.5 textcolor rgb '#334155'\n"
      "set xtics (10, 16, 24, 32, 48, 64, 96, 128, 192)\n"
      "set ytics (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20)\n"
      "set xlabel textcolor rgb '#334155'\n"
      "set ylabel 'L1 error of the number [%]' textcolor rgb '#334155'\n"
      "set grid ytics lt 1 lw 0.6 lc rgb '#e2e8f0'\n"
      "set key at graph 1.04,1.0 left top Left reverse samplen 1.6 spacing 1.15 textcolor rgb '#334155'\n"
      "set format y '%g'\n";
  for (const Panel& panel : panels) script += script_of(panel, panel.title == group::kTwoSolids);
  return script + "unset multiplot\nunset output\n";
}

Status write_convergence_plot(std::span<const Verification> results, const std::filesystem::path& svg) {
  if (panels_of(results).empty())
    return Error{
        fmt::format("{}: there is no order to draw: no case ran on two grids. Leave --bins out.", svg.string())};
  return pilot::draw_svg(convergence_script(results), svg);
}

}  // namespace granary::pbm
