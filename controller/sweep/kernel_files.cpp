#include "controller/sweep/kernel_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/report/gnuplot.hpp"
#include "controller/report/script.hpp"

namespace granary::sweep {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostDrawn = 6;

/// The DEM solid, the balance with its kernel dashed; held-out cases first.
std::string d50_script(const std::vector<ResolvedCase>& cases, const std::vector<Comparison>& comparisons) {
  std::vector<std::size_t> drawn;
  for (const bool trained : {false, true})
    for (std::size_t i = 0; i < cases.size(); ++i)
      if (cases[i].trained == trained && drawn.size() < kMostDrawn) drawn.push_back(i);
  report::LinePlot plot;
  plot.x_title = "time [s]";
  plot.y_title = "d50 by volume [mm]";
  for (const std::size_t i : drawn)
    if (comparisons[i].time.size() > plot.x.size()) plot.x = comparisons[i].time;
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    const Comparison& one = comparisons[drawn[k]];
    const std::string colour = report::sequence_colour(k, drawn.size());
    const std::string name =
        fmt::format("{}{}", fmt::join(cases[drawn[k]].values, ", "), cases[drawn[k]].trained ? "" : " (held out)");
    plot.lines.push_back({report::shortened(name, 36), colour, report::divided(one.dem_d50, 1e-3), false});
    plot.lines.push_back({"", colour, report::divided(one.pbm_d50, 1e-3), true});
  }
  return report::line_plot_script(plot);
}

}  // namespace

std::string comparison_csv(const std::vector<ResolvedCase>& cases, const std::vector<Comparison>& comparisons) {
  std::string text =
      "case,settings,fitted,time_s,dem_d50_m,pbm_d50_m,mean_error,last_error,dem_fragments,pbm_fragments\n";
  for (std::size_t i = 0; i < comparisons.size(); ++i) {
    const Comparison& one = comparisons[i];
    text += fmt::format("{},{},{},{:.4g},{:.6g},{:.6g},{:.4f},{:.4f},{:.6g},{:.6g}\n", one.name,
                        fmt::join(cases[i].values, " "), cases[i].trained ? "yes" : "no", one.time.back(),
                        one.dem_d50.back(), one.pbm_d50.back(), one.mean_error(), one.last_error(),
                        one.dem_number.back(), one.pbm_number.back());
  }
  return text;
}

Status write_kernel(const BreakageKernel& kernel, const std::vector<ResolvedCase>& cases,
                    const std::vector<Comparison>& comparisons, const fs::path& folder) {
  GRANARY_CHECK(make_folders(folder));
  GRANARY_CHECK(json::write_file(folder / "kernel.json", to_json(kernel)));
  for (const ResolvedCase& one : cases)
    GRANARY_CHECK(json::write_file(folder / (one.name + ".json"), kernel_file(kernel, one)));
  GRANARY_CHECK(write_text_atomically(folder / "comparison.csv", comparison_csv(cases, comparisons)));
  report::GnuplotPlotter gnuplot;
  GRANARY_TRY(const auto drawn, gnuplot.draw({{"d50", 760, 420, d50_script(cases, comparisons)}}));
  return write_text_atomically(folder / "d50.svg", report::as_file(drawn.front()));
}

}  // namespace granary::sweep
