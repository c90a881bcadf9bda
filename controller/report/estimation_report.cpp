#include "controller/report/estimation_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "controller/report/html.hpp"
#include "controller/report/page.hpp"
#include "controller/report/script.hpp"

namespace granary::report {
namespace {

using Datum = EstimationSummary::Datum;
using Parameter = EstimationSummary::Parameter;

std::string in_unit(double value, const std::string& unit) {
  if (unit == "m") return diameter(value);
  return number(value) + (unit == "1" || std::isnan(value) ? "" : " " + unit);
}

std::string parameters_table(const EstimationSummary& e) {
  std::vector<std::vector<std::string>> rows;
  for (const Parameter& p : e.parameters)
    rows.push_back(
        {p.name, p.key, in_unit(p.start, p.unit), in_unit(p.value, p.unit),
         std::isnan(p.low) ? "not known yet" : fmt::format("{} to {}", in_unit(p.low, p.unit), in_unit(p.high, p.unit)),
         fmt::format("{} to {}", in_unit(p.from, p.unit), in_unit(p.to, p.unit))});
  return table({{"parameter"},
                {"setting"},
                {"in the workflow", kNumber},
                {"estimated", kNumber},
                {"95 % interval", kNumber},
                {"looked for in", kNumber}},
               rows);
}

/// Pairs that go together, strongest first.
std::string correlations_table(const EstimationSummary& e) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < e.correlation.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!std::isnan(e.correlation[i][j]))
        rows.push_back({e.parameters[j].name, e.parameters[i].name, fmt::format("{:+.2f}", e.correlation[i][j])});
  if (rows.empty()) return "";
  return table({{"parameter"}, {"and"}, {"correlation", kNumber}}, rows);
}

std::string data_table(const EstimationSummary& e) {
  std::vector<std::vector<std::string>> rows;
  for (const Datum& d : e.data)
    rows.push_back({d.what + (d.held_out != 0 ? " (held out)" : ""), fmt::format("{:.4g} s", d.time),
                    in_unit(d.measured, d.unit), in_unit(d.error, d.unit), in_unit(d.fitted, d.unit),
                    std::isnan(d.fitted) ? "–" : fmt::format("{:+.1f}", (d.fitted - d.measured) / d.error)});
  return table({{"datum", kProse},
                {"at", kNumber},
                {"measured", kNumber},
                {"error", kNumber},
                {"model", kNumber},
                {"off by errors", kNumber}},
               rows);
}

std::string summary_table(const CampaignResults& r) {
  const EstimationSummary& e = r.estimation;
  const auto failed = std::count_if(e.cost.begin(), e.cost.end(), [](double cost) { return std::isnan(cost); });
  return table({{"estimation"}, {"", kNumber}},
               {{"evaluations (failed or lost)", fmt::format("{} ({})", e.cost.size(), failed)},
                {"how far it came", e.phase},
                {"squared misfit per free datum", number(e.misfit)},
                {"mean square of the held-out residuals", number(e.held_out)},
                {"idle core time worked on", duration(e.used)},
                {"core time left idle", duration(e.left)},
                {"wall time of the coupling", duration(e.coupled_wall)}});
}

/// The best so far of each version of the rates.
std::vector<double> best_so_far(const EstimationSummary& e) {
  std::vector<double> best;
  for (std::size_t k = 0; k < e.cost.size(); ++k) {
    const bool begins = k == 0 || e.version[k] != e.version[k - 1];
    const double before = begins ? std::numeric_limits<double>::quiet_NaN() : best.back();
    best.push_back(std::isnan(before) ? e.cost[k] : std::isnan(e.cost[k]) ? before : std::min(before, e.cost[k]));
  }
  return best;
}

/// Thousands of evaluations look the same as a thousand: the page stays small.
Figure objective(const EstimationSummary& e, const char* id, const char* title, const char* x_title,
                 const std::vector<double>& x) {
  Figure figure{title,
                "Half the sum of squares of each evaluation, and the best so far; new rates begin anew.",
                {id, 620, 340, ""},
                "no evaluation came to its end"};
  if (!has_numbers(e.cost)) return figure;
  constexpr std::size_t kMost = 2000;
  const std::size_t every = e.cost.size() / kMost + 1;
  const std::vector<double> best = best_so_far(e);
  std::vector<std::vector<double>> columns(3);
  std::vector<std::size_t> breaks;
  for (std::size_t k = 0; k < e.cost.size(); ++k) {
    const bool begins = k > 0 && e.version[k] != e.version[k - 1];
    if (k % every != 0 && !begins) continue;
    if (begins) breaks.push_back(columns[0].size());
    columns[0].push_back(x[k]);
    columns[1].push_back(e.cost[k]);
    columns[2].push_back(best[k]);
  }
  figure.plot.script = data_block("data", columns, breaks) +
                       fmt::format(
                           "set logscale y\nset xlabel {}\nset ylabel 'half the sum of squares'\n"
                           "plot $data using 1:2 with points pt 7 ps 0.25 lc rgb '#94a3b8' title 'evaluations', \\\n"
                           "     $data using 1:3 with lines lw 2 lc rgb '{}' title 'best so far'\n",
                           text_literal(x_title), kind_colour("estimation"));
  return figure;
}

/// Diameters at the outlet: measured, by the best trial, and by the final run.
Figure diameters(const EstimationSummary& e) {
  Figure figure{"Diameters that flow out, against the data",
                "Points with their errors: measured (hollow: held out). Crosses: the fit. Lines: the final run.",
                {"estimation-fit", 620, 340, ""},
                "no diameter at the outlet was measured"};
  std::string script;
  std::vector<std::string> draws;
  const std::vector<std::pair<std::string, const std::vector<double>*>> kinds{
      {"d10", &e.final_d10}, {"d50", &e.final_d50}, {"d90", &e.final_d90}};
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    const std::string colour = sequence_colour(k, kinds.size());
    std::vector<std::vector<double>> columns(5);
    for (const Datum& d : e.data)
      if (d.what == kinds[k].first + ", outlet")
        for (auto& [column, value] : std::vector<std::pair<int, double>>{{0, d.time},
                                                                         {1, 1e6 * d.measured},
                                                                         {2, 1e6 * d.error},
                                                                         {3, 1e6 * d.fitted},
                                                                         {4, d.held_out != 0 ? 6.0 : 7.0}})
          columns[static_cast<std::size_t>(column)].push_back(value);
    if (columns[0].empty()) continue;
    script += data_block("data" + kinds[k].first, columns);
    draws.push_back(
        fmt::format("$data{0} using 1:2:3 with yerrorbars pt -1 lc rgb '{1}' notitle, \\\n"
                    "     $data{0} using 1:2:5 with points pt variable ps 0.6 lc rgb '{1}' title '{0}', \\\n"
                    "     $data{0} using 1:4 with points pt 2 ps 0.7 lc rgb '{1}' notitle",
                    kinds[k].first, colour));
    if (!has_numbers(*kinds[k].second)) continue;
    script += data_block("final" + kinds[k].first, {e.final_time, divided(*kinds[k].second, 1e-6)});
    draws.push_back(fmt::format("$final{} using 1:2 with lines lw 1.5 lc rgb '{}' notitle", kinds[k].first, colour));
  }
  if (draws.empty()) return figure;
  figure.plot.script = script + "set xlabel 'process time [s]'\nset ylabel 'diameter [µm]'\nset yrange [0:*]\nplot ";
  for (std::size_t k = 0; k < draws.size(); ++k) figure.plot.script += (k > 0 ? ", \\\n     " : "") + draws[k];
  figure.plot.script += "\n";
  return figure;
}

}  // namespace

std::string estimation_html(const CampaignResults& r) {
  const EstimationSummary& e = r.estimation;
  std::string html = panel(parameters_table(e));
  for (const std::string& warning : e.warnings) html += panel("<strong>" + escaped(warning) + "</strong>");
  const std::string correlations = correlations_table(e);
  html += "<div class=\"two\">\n" + panel(summary_table(r)) + (correlations.empty() ? "" : panel(correlations)) +
          "</div>\n";
  std::vector<std::vector<std::string>> rows;
  for (std::size_t k = 0; k < e.adopted_by.size(); ++k) {
    std::string values;
    for (std::size_t p = 0; p < e.parameters.size(); ++p)
      values += (p > 0 ? ", " : "") + e.parameters[p].name + " " + in_unit(e.adopted[k][p], e.parameters[p].unit);
    rows.push_back({e.adopted_by[k], duration(e.adopted_time[k]), values});
  }
  if (!rows.empty()) html += panel(table({{"burst"}, {"wall time", kNumber}, {"took the values", kProse}}, rows));
  return html + panel(data_table(e));
}

std::vector<Figure> estimation_figures(const CampaignResults& r) {
  const EstimationSummary& e = r.estimation;
  std::vector<double> count(e.cost.size());
  std::iota(count.begin(), count.end(), 1.0);
  return {objective(e, "objective-time", "Objective over wall time", "wall time [s]", e.time),
          objective(e, "objective-count", "Objective over evaluations", "evaluations", count), diameters(e)};
}

}  // namespace granary::report
