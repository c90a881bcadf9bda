#include "controller/report/gnuplot.hpp"

#include <fmt/format.h>

#include "pilot/launch/run_program.hpp"

namespace granary::report {
namespace {

constexpr double kTimeout = 60.0;  // a page takes about a second

/// Every `from` in the text becomes `to`.
void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

void remove_between(std::string& text, std::string_view from, std::string_view to) {
  const auto begin = text.find(from);
  const auto end = begin == std::string::npos ? begin : text.find(to, begin);
  if (end != std::string::npos) text.erase(begin, end + to.size() - begin);
}

/// One drawing as it may stand beside others in a page.
std::string for_page(std::string svg, const Plot& plot) {
  remove_between(svg, "<title>", "</title>");  // would pop up as a tool tip
  remove_between(svg, "<desc>", "</desc>");
  for (const char* quote : {"\"", "'"}) {
    replace_all(svg, fmt::format(" id={}", quote), fmt::format(" id={}{}-", quote, plot.id));
    replace_all(svg, fmt::format("href={}#", quote), fmt::format("href={}#{}-", quote, plot.id));
  }
  replace_all(svg, "url(#", fmt::format("url(#{}-", plot.id));
  return svg;
}

}  // namespace

std::string gnuplot_input(const std::vector<Plot>& plots) {
  std::string input = "set encoding utf8\nset datafile missing 'NaN'\n";
  for (const auto& plot : plots) {
    input += "reset\nundefine $*\n";
    input += fmt::format("set terminal svg noenhanced size {},{} dynamic font 'system-ui,sans-serif,13'\n", plot.width,
                         plot.height);
    input +=
        "set border 3 lc rgb '#94a3b8' lw 1\n"
        "set tics out nomirror scale 0.5 textcolor rgb '#334155'\n"
        "set xlabel textcolor rgb '#334155'\nset ylabel textcolor rgb '#334155'\n"
        "set grid ytics lt 1 lw 0.6 lc rgb '#e2e8f0'\n"
        "set key outside right top Left reverse samplen 1.6 spacing 1.15 textcolor rgb '#334155'\n"
        "set format '%g'\n"
        "set tmargin 1.8\n";
    input += plot.script;
  }
  return input + "unset output\n";
}

Result<std::vector<std::string>> split_drawings(std::string_view printed, const std::vector<Plot>& plots) {
  constexpr std::string_view kEnd = "</svg>";
  std::vector<std::string> drawings;
  std::size_t at = 0;
  while ((at = printed.find("<svg", at)) != std::string_view::npos) {
    const auto end = printed.find(kEnd, at);
    if (end == std::string_view::npos) break;
    if (drawings.size() < plots.size())
      drawings.push_back(for_page(std::string(printed.substr(at, end + kEnd.size() - at)), plots[drawings.size()]));
    else
      return Error{fmt::format("gnuplot made more than the {} drawings it was asked for.", plots.size()),
                   Exit::internal};
    at = end;
  }
  if (drawings.size() == plots.size()) return drawings;
  return Error{fmt::format("gnuplot stopped at plot \"{}\": {} of {} drawings came.", plots[drawings.size()].id,
                           drawings.size(), plots.size()),
               Exit::internal};
}

Result<std::vector<std::string>> GnuplotPlotter::draw(const std::vector<Plot>& plots) {
  if (plots.empty()) return std::vector<std::string>{};
  auto ran = pilot::run_program({"gnuplot", "-"}, gnuplot_input(plots), kTimeout);
  if (!ran)
    return Error{fmt::format("{} The report's plots are drawn by gnuplot (Debian: apt-get install gnuplot-nox); "
                             "results.h5 is complete, and "
                             "`granary report` makes the page later.",
                             ran.error().message),
                 Exit::task_failed};
  if (ran->exit_code != 0)
    return Error{fmt::format("gnuplot ended with exit code {} (signal {}): {}", ran->exit_code, ran->signal,
                             ran->err.substr(0, 2000)),
                 Exit::internal};
  auto drawings = split_drawings(ran->out, plots);
  if (!drawings)
    return Error{fmt::format("{} It printed: {}", drawings.error().message, ran->err.substr(0, 2000)),
                 drawings.error().exit};
  return drawings;
}

std::string as_file(std::string svg) {
  if (svg.find("xmlns=") == std::string::npos)
    svg.insert(std::string_view("<svg").size(), " xmlns=\"http://www.w3.org/2000/svg\"");
  return svg;
}

}  // namespace granary::report
