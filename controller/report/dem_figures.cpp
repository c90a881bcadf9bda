#include <fmt/format.h>

#include <cmath>

#include "controller/report/figures.hpp"
#include "controller/report/script.hpp"

namespace granary::report {
namespace {

Figure over_dem(const CampaignResults& results, const char* id, const char* title, LinePlot plot,
                const std::string& caption) {
  const auto& dem = results.dem;
  plot.x_title = "DEM time [s]";
  plot.x = dem.time;
  for (std::size_t w = 1; w < dem.time.size(); ++w)
    if (dem.burst[w] != dem.burst[w - 1]) plot.breaks.push_back(w);
  for (const auto& burst : results.bursts)
    if (burst.kind == "dem") plot.marks.push_back({burst.dem_start, std::to_string(burst.number)});
  return {title, caption, {id, 620, 340, line_plot_script(plot)}, "the results hold no DEM series for it"};
}

Figure one_line(const CampaignResults& results, const char* id, const char* title, const std::vector<double>& values,
                double unit, const char* y_title, const char* y_unit, const char* caption) {
  const auto in_unit = divided(values, unit);
  const Scale scale = scale_for({&in_unit});
  LinePlot plot;
  plot.lines = {{"", std::string(kind_colour("dem")), divided(in_unit, scale.factor), false}};
  plot.y_title = fmt::format("{} [{}{}]", y_title, scale.prefix, y_unit);
  return over_dem(results, id, title, std::move(plot), caption);
}

Figure speeds(const CampaignResults& results) {
  const auto& speed = results.dem.speed;
  const std::size_t n = speed.empty() ? 0 : speed.front().size();
  const std::size_t every = (n + 7) / 8;
  LinePlot plot;
  plot.y_title = "mean speed [m/s]";
  for (std::size_t k = 0; k < n; ++k)
    plot.lines.push_back({k % every == 0 || k + 1 == n ? fmt::format("class {}", k + 1) : "", sequence_colour(k, n),
                          column_of(speed, k), false});
  return over_dem(results, "dem-speed", "Mean speed of each size class", std::move(plot),
                  "Classes from small (1) to large.");
}

Figure power(const CampaignResults& results) {
  const auto& dem = results.dem;
  LinePlot plot;
  plot.y_title = "power [W]";
  double most_torque = 0.0;
  for (std::size_t b = 0; b < dem.bodies.size(); ++b) {
    const auto values = column_of(dem.power, b);
    if (!has_numbers(values)) continue;
    plot.lines.push_back({shortened(dem.bodies[b], 14), std::string(category_colour(b + 1)), values, false});
    for (const auto& row : dem.torque)
      if (std::abs(row[b]) > most_torque) most_torque = std::abs(row[b]);
  }
  return over_dem(results, "dem-power", "Power the blades give to the particles", std::move(plot),
                  fmt::format("Of the simulated particles, means over a window; the largest torque about an axis is "
                              "{:.3g} N m. Not known where stock walls were used.",
                              most_torque));
}

}  // namespace

std::vector<Figure> dem_figures(const CampaignResults& results) {
  const auto& dem = results.dem;
  return {one_line(results, "dem-energy", "Kinetic energy of the DEM", dem.kinetic_energy, 1.0, "kinetic energy", "J",
                   "Dotted: a DEM burst begins, its number on top."),
          speeds(results),
          one_line(results, "dem-particles", "Particles in the DEM", dem.particles, 1.0, "particles", "–",
                   "As simulated (coarse-grained)."),
          power(results),
          one_line(results, "dem-overlap", "Largest overlap", dem.largest_overlap, 0.01, "overlap over radius", "%",
                   "The largest of each window, over the radius of the smaller particle: what a soft contact costs.")};
}

}  // namespace granary::report
