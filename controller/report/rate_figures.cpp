#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/units.hpp"
#include "controller/report/figures.hpp"
#include "controller/report/script.hpp"

namespace granary::report {
namespace {

constexpr const char* kNoRates = "no DEM burst gave rates";

/// One class pair of the heat map.
struct Cell {
  std::size_t p, q;
  double rate, relative_error;
};

/// The pairs that collided at all.
std::vector<Cell> cells_of(const DemRates& rates) {
  std::vector<Cell> cells;
  for (std::size_t p = 0; p < rates.collision_rate.size(); ++p)
    for (std::size_t q = 0; q < rates.collision_rate[p].size(); ++q) {
      const double rate = rates.collision_rate[p][q];
      if (std::isfinite(rate) && rate > 0.0) cells.push_back({p, q, rate, rates.collision_rate_error[p][q] / rate});
    }
  return cells;
}

/// Class diameters as tic labels of an axis, at most about a dozen.
std::string class_tics(const char* axis, const std::vector<double>& diameter, const LengthUnit& unit) {
  std::vector<std::string> tics;
  const std::size_t every = (diameter.size() + 11) / 12;
  for (std::size_t k = 0; k < diameter.size(); k += every)
    tics.push_back(fmt::format("'{:.3g}' {}", diameter[k] / unit.metres, k));
  return fmt::format("set {}tics ({})\n", axis, fmt::join(tics, ", "));
}

Figure heat_map(const CampaignResults& results) {
  Figure figure{"Collision rates by pair of size classes", "", {"collision-map", 620, 420, ""}, kNoRates};
  if (results.rates.empty()) return figure;
  const DemRates& rates = results.rates.back();
  const auto cells = cells_of(rates);
  figure.missing = fmt::format("no collisions were counted in burst {}", rates.burst);
  if (cells.empty()) return figure;

  std::vector<double> p, q, rate, error;
  for (const auto& cell : cells) {
    p.push_back(static_cast<double>(cell.p));
    q.push_back(static_cast<double>(cell.q));
    rate.push_back(cell.rate);
    error.push_back(100.0 * cell.relative_error);
  }
  const Scale scale = scale_for({&rate});
  const auto [low, high] = std::minmax_element(rate.begin(), rate.end());
  const bool flat = *high < 1.01 * *low;
  const LengthUnit unit = length_unit_for(rates.diameter.empty() ? 0.0 : rates.diameter.back());
  const double n = static_cast<double>(rates.collision_rate.size());

  std::string script = data_block("cells", {p, q, divided(rate, scale.factor), error});
  script += class_tics("x", rates.diameter, unit) + class_tics("y", rates.diameter, unit);
  script += fmt::format("set xlabel 'class diameter [{0}]'\nset ylabel 'class diameter [{0}]'\n", unit.name);
  script +=
      fmt::format("set xrange [-0.5:{0}]\nset yrange [-0.5:{0}]\nset size ratio 0.8\nunset grid\nunset key\n", n - 0.5);
  script += fmt::format("set logscale cb\nset cbrange [{:.6g}:{:.6g}]\n", *low / scale.factor * (flat ? 0.5 : 1.0),
                        *high / scale.factor * (flat ? 2.0 : 1.0));
  script += fmt::format("set cblabel 'C [{}m³/s]'\n", scale.prefix);
  script += "set palette defined (0 '#440154', 0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fde725')\n";
  script += "plot $cells using 1:2:(0.5):(0.5):3 with boxxyerror fs solid 1.0 noborder lc palette notitle";
  if (n <= 9.0)  // the standard error in each cell, light on dark and dark on light
    script += fmt::format(
        ", \\\n     $cells using 1:2:(sprintf('±%.0f %%', $4)):($3 < {:.6g} ? 0xffffff : 0x1e293b) with labels font "
        "',11' tc rgb variable notitle",
        std::sqrt(*low * *high) / scale.factor);
  figure.plot.script = script + "\n";
  figure.caption = fmt::format(
      "C of the last DEM burst (burst {}), at real sizes; in the cells its standard error. Pairs that never collided "
      "stay white.",
      rates.burst);
  return figure;
}

double total_collisions(const DemRates& rates) {
  double total = 0.0;
  for (std::size_t p = 0; p < rates.collisions.size(); ++p)
    for (std::size_t q = p; q < rates.collisions[p].size(); ++q) total += rates.collisions[p][q];
  return total;
}

/// Collisions per time of each burst with their Poisson error, as simulated.
Figure totals(const CampaignResults& results) {
  Figure figure{"Collisions and impacts by DEM burst",
                "Means over each burst's windows, as simulated (coarse-grained particles). Bars: standard error.",
                {"collision-totals", 620, 420, ""},
                kNoRates};
  std::vector<double> burst, rate, error;
  for (const auto& rates : results.rates) {
    const double total = total_collisions(rates);
    if (!(rates.measured > 0.0)) continue;
    burst.push_back(static_cast<double>(rates.burst));
    rate.push_back(total / rates.measured);
    error.push_back(std::sqrt(total) / rates.measured);
  }
  if (burst.empty()) return figure;

  const auto& dem = results.dem;
  std::vector<std::vector<double>> impacts(dem.bodies.size());
  for (const double b : burst)
    for (std::size_t body = 0; body < impacts.size(); ++body) {
      double sum = 0.0, n = 0.0;
      for (std::size_t w = 0; w < dem.time.size(); ++w)
        if (static_cast<double>(dem.burst[w]) == b && std::isfinite(dem.impacts[w][body]))
          sum += dem.impacts[w][body], n += 1.0;
      impacts[body].push_back(sum / n);
    }

  std::vector<const std::vector<double>*> all{&rate};
  for (const auto& list : impacts) all.push_back(&list);
  const Scale scale = scale_for(all);
  std::vector<std::vector<double>> columns{burst, divided(rate, scale.factor), divided(error, scale.factor)};
  std::string draws = fmt::format(
      "$data using 1:2:3 with yerrorbars pt 7 ps 0.8 lw 2 lc rgb '{0}' title 'particle–particle', $data using 1:2 with "
      "lines lw 1.5 lc rgb '{0}' notitle",
      category_colour(0));
  for (std::size_t body = 0; body < impacts.size(); ++body) {
    if (!has_numbers(impacts[body])) continue;
    columns.push_back(divided(impacts[body], scale.factor));
    draws += fmt::format(
        ", \\\n     $data using 1:{} with linespoints lw 1.5 pt 7 ps 0.8 lc rgb '{}' title {} noenhanced",
        columns.size(), category_colour(body + 1), text_literal("impacts on " + shortened(dem.bodies[body], 14)));
  }
  figure.plot.script =
      data_block("data", columns) + fmt::format(
                                        "set xlabel 'burst'\nset ylabel 'per time [{}1/s]'\nset yrange [0:*]\nset "
                                        "xrange [{}:{}]\nset xtics 1 nomirror\nplot {}\n",
                                        scale.prefix, burst.front() - 0.5, burst.back() + 0.5, draws);
  if (burst.back() - burst.front() > 12.0)
    figure.plot.script.replace(figure.plot.script.find("set xtics 1 nomirror\n"), 21, "");
  return figure;
}

/// Counts as a density over ln U.
std::vector<double> density(const SpeedHistogram& speed) {
  std::vector<double> q;
  double total = 0.0;
  for (const double count : speed.count) total += count;
  if (!(total > 0.0) || speed.edge.size() != speed.count.size() + 1) return q;
  for (std::size_t i = 0; i < speed.count.size(); ++i)
    q.push_back(speed.count[i] / total / std::log(speed.edge[i + 1] / speed.edge[i]));
  return q;
}

/// The edges in use: a histogram may begin at 0, which has no place on a logarithmic axis.
std::vector<double> speed_centres(const std::vector<double>& edge) {
  std::vector<double> middle;
  for (std::size_t i = 0; i + 1 < edge.size(); ++i)
    middle.push_back(edge[i] > 0.0 ? std::sqrt(edge[i] * edge[i + 1]) : 0.5 * edge[i + 1]);
  return middle;
}

/// The curve (x, y) at other places, linear in ln x; NaN outside. Bursts with another coarse-graining have other
/// classes.
std::vector<double> resampled(const std::vector<double>& x, const std::vector<double>& y,
                              const std::vector<double>& at) {
  std::vector<double> out;
  for (const double place : at) {
    const auto right = static_cast<std::size_t>(std::lower_bound(x.begin(), x.end(), place) - x.begin());
    if (right == x.size() || y.size() != x.size() || (right == 0 && x[0] != place)) {
      out.push_back(std::nan(""));
    } else if (x[right] == place) {
      out.push_back(y[right]);
    } else {
      const double t = std::log(place / x[right - 1]) / std::log(x[right] / x[right - 1]);
      out.push_back((1.0 - t) * y[right - 1] + t * y[right]);
    }
  }
  return out;
}

std::vector<double> lognormal(const std::vector<double>& speed, double ln_mean, double ln_sigma) {
  std::vector<double> q;
  for (const double u : speed) {
    const double z = (std::log(u) - ln_mean) / ln_sigma;
    q.push_back(std::exp(-0.5 * z * z) / (ln_sigma * std::sqrt(2.0 * kPi)));
  }
  return q;
}

Figure speeds(const CampaignResults& results, const char* id, const char* title, SpeedHistogram DemRates::*member) {
  LinePlot plot;
  plot.x_title = "relative normal speed [m/s]";
  plot.y_title = "density, d(share)/d(ln U) [–]";
  plot.log_x = true;
  const std::size_t n = results.rates.size();
  if (n > 0) plot.x = speed_centres((results.rates.back().*member).edge);
  const std::size_t every = (n + 7) / 8;
  for (std::size_t i = 0; i < n; ++i) {
    const SpeedHistogram& speed = results.rates[i].*member;
    plot.lines.push_back({i % every == 0 || i + 1 == n ? fmt::format("burst {}", results.rates[i].burst) : "",
                          sequence_colour(i, n), resampled(speed_centres(speed.edge), density(speed), plot.x), false});
  }
  if (n > 0) {
    const SpeedHistogram& last = results.rates.back().*member;
    if (last.ln_sigma > 0.0 && !density(last).empty())
      plot.lines.push_back({fmt::format("log-normal fit, {}", results.rates.back().burst), "#1e293b",
                            lognormal(plot.x, last.ln_mean, last.ln_sigma), true});
  }
  trim_to_curves(plot);
  return {title,
          "Speeds at first touch. Dashed: the log-normal law of the last burst, which the kernels use.",
          {id, 620, 340, line_plot_script(plot)},
          kNoRates};
}

}  // namespace

std::vector<Figure> rate_figures(const CampaignResults& results) {
  return {heat_map(results), totals(results),
          speeds(results, "collision-speed", "Speeds of collisions between particles", &DemRates::collision_speed),
          speeds(results, "impact-speed", "Speeds of impacts on walls and blades", &DemRates::impact_speed)};
}

}  // namespace granary::report
