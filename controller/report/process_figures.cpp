#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "controller/report/figures.hpp"
#include "controller/report/script.hpp"

namespace granary::report {
namespace {

/// A line a compartment; with many, only some are in the legend.
std::vector<Line> compartment_lines(const Rows& rows, double unit) {
  const std::size_t n = rows.empty() ? 0 : rows.front().size();
  const std::size_t every = (n + 7) / 8;
  std::vector<Line> lines;
  for (std::size_t x = 0; x < n; ++x) {
    const bool named = n > 1 && (x % every == 0 || x + 1 == n);
    lines.push_back(
        {named ? fmt::format("comp. {}", x + 1) : "", sequence_colour(x, n), divided(column_of(rows, x), unit), false});
  }
  return lines;
}

double largest(const Rows& rows) {
  double most = 0.0;
  for (const auto& row : rows)
    for (const double value : row)
      if (std::isfinite(value)) most = std::max(most, value);
  return most;
}

Scale scale_of(const Rows& rows) {
  std::vector<const std::vector<double>*> lists;
  for (const auto& row : rows) lists.push_back(&row);
  return scale_for(lists);
}

/// "[10⁸]", "[–]"
std::string bracketed(const Scale& scale) {
  return scale.prefix.empty() ? "[–]" : "[" + scale.prefix.substr(0, scale.prefix.size() - 1) + "]";
}

std::vector<Mark> dem_marks(const std::vector<BurstSummary>& bursts) {
  std::vector<Mark> marks;
  for (const auto& burst : bursts)
    if (burst.kind == "dem") marks.push_back({burst.process_start, std::to_string(burst.number)});
  return marks;
}

/// Element by element: a / (a + b + c), and NaN where there is nothing.
Rows liquid_share(const PbmSeries& pbm) {
  Rows share = pbm.liquid;
  for (std::size_t t = 0; t < share.size(); ++t)
    for (std::size_t x = 0; x < share[t].size(); ++x) share[t][x] /= pbm.solid[t][x] + pbm.liquid[t][x] + pbm.gas[t][x];
  return share;
}

Figure over_process(const CampaignResults& results, const std::string& id, const std::string& title, LinePlot plot,
                    std::string caption) {
  plot.x_title = "process time [s]";
  plot.x = results.pbm.time;
  plot.marks = dem_marks(results.bursts);
  return {title, std::move(caption), {id, 620, 340, line_plot_script(plot)}, "the results hold no PBM series for it"};
}

Figure d50_figure(const CampaignResults& results) {
  const auto& pbm = results.pbm;
  const LengthUnit unit = length_unit_for(largest(pbm.d50));
  LinePlot plot;
  plot.y_title = fmt::format("diameter [{}]", unit.name);
  plot.lines = compartment_lines(pbm.d50, unit.metres);
  if (!pbm.d50.empty() && !pbm.d50.front().empty()) {
    const std::size_t last = pbm.d50.front().size() - 1;
    plot.bands.push_back({last > 0 ? fmt::format("d10–d90 of {}", last + 1) : "d10–d90", plot.lines.back().colour,
                          divided(column_of(pbm.d10, last), unit.metres),
                          divided(column_of(pbm.d90, last), unit.metres)});
  }
  return over_process(results, "d50", "Median diameter d50 by volume", std::move(plot),
                      "Line: d50. Shaded: d10 to d90 of the last compartment. Dotted: a DEM burst, its number on top.");
}

}  // namespace

std::vector<Figure> process_figures(const CampaignResults& results) {
  const auto& pbm = results.pbm;
  std::vector<Figure> figures{d50_figure(results)};
  const auto by_compartment = [&](const char* id, const char* title, const Rows& rows, double unit,
                                  const std::string& y, bool from_zero, const char* caption) {
    LinePlot plot;
    plot.y_title = y;
    plot.lines = compartment_lines(rows, unit);
    plot.from_zero = from_zero;
    figures.push_back(over_process(results, id, title, std::move(plot), caption));
  };

  const Scale particles = scale_of(pbm.number);
  by_compartment("number", "Number of particles", pbm.number, particles.factor, "particles " + bracketed(particles),
                 true, "Particles in each compartment, at real sizes.");
  by_compartment("porosity", "Porosity of the granules", pbm.porosity, 1.0, "porosity [–]", false,
                 "Volume of liquid and gas over particle volume.");
  by_compartment("liquid", "Liquid in the granules", liquid_share(pbm), 0.01, "liquid volume share [%]", true,
                 "Volume of liquid over particle volume.");
  const Scale holdup = scale_of(pbm.solid);
  by_compartment("holdup", "Solid hold-up", pbm.solid, holdup.factor, fmt::format("solid volume [{}m³]", holdup.prefix),
                 true, "Solid volume in each compartment.");
  LinePlot outflow;
  const bool flows =
      std::any_of(pbm.outlet_solid.begin(), pbm.outlet_solid.end(), [](double rate) { return rate > 0.0; });
  if (flows) outflow.lines = {{"", std::string(kind_colour("pbm")), divided(pbm.outlet_solid, 1e-3), false}};
  outflow.y_title = "solids [g/s]";
  figures.push_back(over_process(results, "outflow", "Outflow of solids", std::move(outflow),
                                 "Mass of solids leaving the last compartment."));
  if (!flows && !pbm.time.empty()) figures.back().missing = "nothing flows out";
  return figures;
}

}  // namespace granary::report
