#include "controller/bench/pbm_plot.hpp"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "common/files.hpp"
#include "pilot/launch/run_program.hpp"

namespace granary::bench {
namespace {

using json::Value;

constexpr double kTimeout = 60.0;  // [s]

constexpr const char* kStyle = R"(set encoding utf8
set terminal svg noenhanced size 860,540 dynamic font 'system-ui,sans-serif,15' background '#ffffff'
set border 3 lc rgb '#94a3b8' lw 1
set tics out nomirror scale 0.5 textcolor rgb '#334155'
set xlabel 'CPU time, one core [s]' textcolor rgb '#334155'
set ylabel 'L1 error of the numbers [%]' textcolor rgb '#334155'
set title 'Aggregation of two solids, degree of aggregation 0.8: error against CPU time' textcolor rgb '#0f172a'
set grid xtics ytics lt 1 lw 0.6 lc rgb '#e2e8f0'
set key inside bottom left Left reverse samplen 2 spacing 1.2 textcolor rgb '#334155'
set logscale xy
set format x '10^%T'
set format y '%g'
set terminal svg enhanced
)";

/// Blues from light to dark for the solver, oranges for the reference: finer grids are darker.
const std::map<std::pair<std::string, std::int64_t>, const char*> kColours{
    {{"solver", 16}, "#93c5fd"},   {{"solver", 32}, "#3b82f6"},    {{"solver", 64}, "#1d4ed8"},
    {{"solver", 128}, "#172554"},  {{"reference", 16}, "#fdba74"}, {{"reference", 32}, "#f97316"},
    {{"reference", 64}, "#9a3412"}};

}  // namespace

std::string work_precision_script(const Value& document) {
  std::map<std::pair<std::string, std::int64_t>, std::string> curves;
  for (const Value& row : document["work_precision"].items_or_none())
    curves[{row.text_or("method", ""), row.integer_or("bins", 0)}] +=
        fmt::format("{} {}\n", row.number_or("cpu_s", 0.0), 100.0 * row.number_or("l1_number", 0.0));
  std::string data, plot;
  for (const char* method : {"solver", "reference"})
    for (const auto& [key, points] : curves) {
      if (key.first != method) continue;
      const auto colour = kColours.find(key);
      data += fmt::format("${}_{} << EOD\n{}EOD\n", key.first, key.second, points);
      plot += fmt::format("{}${}_{} with linespoints lw 2 pt {} ps 0.8 lc rgb '{}' title '{}, {} x {} classes'",
                          plot.empty() ? "plot " : ", \\\n     ", key.first, key.second, key.first == "solver" ? 7 : 5,
                          colour == kColours.end() ? "#64748b" : colour->second,
                          key.first == "solver" ? "granary-pbm" : "plain reference", key.second, key.second);
    }
  return kStyle + data + plot + "\nunset output\n";
}

Status draw_work_precision(const Value& document, const std::filesystem::path& file) {
  const auto drawn = pilot::run_program({"gnuplot", "-"}, work_precision_script(document), kTimeout);
  if (!drawn)
    return Error{
        fmt::format("{} The plot is drawn by gnuplot (Debian: apt-get install gnuplot-nox).", drawn.error().message),
        Exit::task_failed};
  if (drawn->exit_code != 0 || drawn->out.find("</svg>") == std::string::npos)
    return Error{fmt::format("gnuplot ended with exit code {} (signal {}): {}", drawn->exit_code, drawn->signal,
                             drawn->err.substr(0, 2000)),
                 Exit::internal};
  return write_text_atomically(file, drawn->out);
}

}  // namespace granary::bench
