#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "controller/report/figures.hpp"
#include "controller/report/script.hpp"

namespace granary::report {
namespace {

/// Volume shares as a density over ln d: share / ln(edge_i+1 / edge_i), so that equal areas on a logarithmic axis are
/// equal volumes. Empty if there is nothing.
std::vector<double> density(const std::vector<double>& edge, const std::vector<double>& share) {
  std::vector<double> q;
  if (edge.size() != share.size() + 1 || std::none_of(share.begin(), share.end(), [](double s) { return s > 0.0; }))
    return q;
  for (std::size_t i = 0; i < share.size(); ++i) q.push_back(share[i] / std::log(edge[i + 1] / edge[i]));
  return q;
}

std::vector<double> centres(const std::vector<double>& edge) {
  std::vector<double> middle;
  for (std::size_t i = 0; i + 1 < edge.size(); ++i) middle.push_back(std::sqrt(edge[i] * edge[i + 1]));
  return middle;
}

LinePlot over_diameter(const std::vector<double>& edge) {
  const LengthUnit unit = length_unit_for(edge.empty() ? 0.0 : std::sqrt(edge.front() * edge.back()));
  LinePlot plot;
  plot.x_title = fmt::format("diameter [{}]", unit.name);
  plot.y_title = "volume density, d(share)/d(ln d) [–]";
  plot.x = divided(centres(edge), unit.metres);
  plot.log_x = true;
  return plot;
}

Figure finished(const std::string& id, const std::string& title, LinePlot plot, std::string caption) {
  trim_to_curves(plot);
  return {title,
          std::move(caption),
          {id, 620, 340, line_plot_script(plot)},
          "the results hold no size distributions for it"};
}

std::string at(double time, const std::string& when) { return shortened(fmt::format("{:.3g} s, {}", time, when)); }

}  // namespace

std::vector<Figure> size_figures(const CampaignResults& results) {
  const auto& sizes = results.sizes;
  const std::size_t n_moments = sizes.compartments.size();
  const std::size_t n_compartments = n_moments == 0 ? 0 : sizes.compartments.front().size();

  LinePlot along = over_diameter(sizes.edge);
  if (n_moments > 0) {
    const std::size_t every = (n_compartments + 7) / 8;
    for (std::size_t x = 0; x < n_compartments; ++x) {
      const auto colour = sequence_colour(x, n_compartments);
      const bool named = x % every == 0 || x + 1 == n_compartments;
      along.lines.push_back({named ? fmt::format("comp. {}", x + 1) : "", colour,
                             density(sizes.edge, sizes.compartments.back()[x]), false});
    }
    const auto first = density(sizes.edge, sizes.compartments.front()[0]);
    if (n_moments > 1) along.lines.push_back({"start, comp. 1", "#64748b", first, true});
  }

  // In time order, without those that say the same twice ("after burst 6" and "end").
  LinePlot through = over_diameter(sizes.edge);
  const bool outlet = std::any_of(sizes.outlet.begin(), sizes.outlet.end(),
                                  [&](const auto& share) { return !density(sizes.edge, share).empty(); });
  const auto shown = [&](std::size_t s) { return outlet ? sizes.outlet[s] : sizes.compartments[s].back(); };
  std::vector<std::size_t> moments;
  for (std::size_t s = 0; s < n_moments && n_compartments > 0; ++s)
    if (s == 0 || sizes.time[s] != sizes.time[s - 1] || shown(s) != shown(s - 1)) moments.push_back(s);
  const std::size_t every = (moments.size() + 7) / 8;
  for (std::size_t m = 0; m < moments.size(); ++m) {
    const std::size_t s = moments[m];
    const bool named = m % every == 0 || m + 1 == moments.size();
    through.lines.push_back({named ? at(sizes.time[s], sizes.when[s]) : "", sequence_colour(m, moments.size()),
                             density(sizes.edge, shown(s)), false});
  }

  const bool only_start = n_moments == 1;
  if (only_start) through.lines.clear();  // the other figure has it
  return {
      finished("sizes-along",
               only_start ? "Size distributions at the start" : "Size distributions at the end, along the granulator",
               std::move(along),
               only_start ? "By volume; equal areas are equal volumes."
                          : "By volume; equal areas are equal volumes. Dashed: where it began."),
      finished("sizes-through",
               outlet ? "Size distribution of what leaves, through time"
                      : "Size distribution of the last compartment, through time",
               std::move(through), "By volume, at the start and after each PBM burst.")};
}

}  // namespace granary::report
