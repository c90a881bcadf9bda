#include "controller/sweep/page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/report/gnuplot.hpp"
#include "controller/report/html.hpp"
#include "controller/report/page.hpp"
#include "controller/report/script.hpp"

namespace granary::sweep {
namespace {

namespace fs = std::filesystem;
using report::Column;
using report::LinePlot;

constexpr std::size_t kMostLegends = 10;

/// What is drawn, and first in the table; each is how the page calls it.
const std::vector<std::pair<std::string, std::string>> kShown{
    {"breakage_ratio", "bonds broken, share of all [-]"},
    {"d50_m", "d50 by volume [m]"},
    {"sigma", "d84 / d50 [-]"},
    {"fragments", "fragments"},
    {"agglomerate_breakage_ratio", "agglomerates broken, share of all [-]"},
    {"broken_by_chopper", "bonds broken by the chopper"},
    {"broken_by_impeller", "bonds broken by the impeller"},
    {"broken_by_shell", "bonds broken by the shell"},
    {"broken_by_particles", "bonds broken by other particles"},
    {"broken_by_none", "bonds broken with no touch near"},
    {"kinetic_energy_J", "kinetic energy [J]"},
    {"impacts_impeller_1_s", "impacts on the impeller [1/s]"},
    {"impacts_chopper_1_s", "impacts on the chopper [1/s]"},
    {"outlet.d50_m", "d50 of the outflow [m]"},
    {"d10_m", "d10 by volume [m]"},
    {"d90_m", "d90 by volume [m]"},
    {"number", "particles"},
    {"porosity", "porosity [-]"}};

bool has_curve(const SweepResults& results, const std::string& name) {
  return std::any_of(results.cases.begin(), results.cases.end(),
                     [&](const CaseResult& one) { return curve_of(one, name) != nullptr; });
}

bool has_figure(const SweepResults& results, const std::string& name) {
  return std::any_of(results.cases.begin(), results.cases.end(),
                     [&](const CaseResult& one) { return std::isfinite(figure_of(one, name)); });
}

/// Between its points; NaN beyond them.
double value_at(const Curve& curve, double time) {
  const auto after = std::lower_bound(curve.time.begin(), curve.time.end(), time);
  if (after == curve.time.end()) return std::nan("");
  const auto i = static_cast<std::size_t>(after - curve.time.begin());
  if (*after == time) return curve.value[i];
  if (i == 0) return std::nan("");
  const double share = (time - curve.time[i - 1]) / (curve.time[i] - curve.time[i - 1]);
  return curve.value[i - 1] + share * (curve.value[i] - curve.value[i - 1]);
}

std::string legend(const CaseResult& one) {
  std::vector<std::string> values;
  for (const std::string& value : one.values) values.push_back(value.empty() ? "as is" : value);
  return report::shortened(fmt::format("{}", fmt::join(values, ", ")), 32);
}

std::string plot_id(const std::string& kind, const std::string& name) {
  std::string id = kind + "-";
  for (const char c : name) id += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '-';
  return id;
}

report::Figure over_time(const SweepResults& results, const std::string& name, const std::string& title) {
  LinePlot plot;
  plot.x_title = "time [s]";
  plot.y_title = title;
  for (const CaseResult& one : results.cases)
    if (const Curve* curve = curve_of(one, name); curve != nullptr && curve->time.size() > plot.x.size())
      plot.x = curve->time;
  const std::size_t n = results.cases.size(), every = (n + kMostLegends - 1) / kMostLegends;
  for (std::size_t i = 0; i < n; ++i) {
    const Curve* curve = curve_of(results.cases[i], name);
    if (curve == nullptr) continue;
    std::vector<double> y;
    for (const double time : plot.x) y.push_back(value_at(*curve, time));
    const bool named = i % every == 0 || i + 1 == n;
    plot.lines.push_back({named ? legend(results.cases[i]) : "", report::sequence_colour(i, n), std::move(y), false});
  }
  return {title, "", {plot_id("time", name), 620, 360, report::line_plot_script(plot)}, "no case has it"};
}

/// A figure at the end of each case, over the last of the settings; a line for each combination of the others.
report::Figure over_setting(const SweepResults& results, const std::string& name, const std::string& title) {
  LinePlot plot;
  plot.y_title = title;
  plot.with_points = true;
  const std::string id = plot_id("setting", name);
  if (results.settings.empty()) return {title, "", {id, 620, 360, ""}, "nothing was swept"};
  plot.x_title = results.settings.back();
  std::map<std::string, std::map<double, double>> lines;
  std::vector<std::string> order;
  for (const CaseResult& one : results.cases) {
    const auto x = leading_number(one.values.back());
    if (!x) return {title, "", {id, 620, 360, ""}, "its setting is not a number"};
    std::vector<std::string> others(one.values.begin(), one.values.end() - 1);
    const std::string line = fmt::format("{}", fmt::join(others, ", "));
    if (lines.count(line) == 0) order.push_back(line);
    lines[line][*x] = figure_of(one, name);
    if (std::find(plot.x.begin(), plot.x.end(), *x) == plot.x.end()) plot.x.push_back(*x);
  }
  std::sort(plot.x.begin(), plot.x.end());
  if (plot.x.size() < 2) return {title, "", {id, 620, 360, ""}, "the last setting has one value only"};
  for (std::size_t i = 0; i < order.size(); ++i) {
    std::vector<double> y;
    for (const double x : plot.x) y.push_back(lines[order[i]].count(x) != 0 ? lines[order[i]][x] : std::nan(""));
    plot.lines.push_back({i < kMostLegends ? report::shortened(order[i], 32) : "",
                          report::sequence_colour(i, order.size()), std::move(y), false});
  }
  return {title, "At the end of each case.", {id, 620, 360, report::line_plot_script(plot)}, "no case has it"};
}

std::string table_of(const SweepResults& results) {
  std::vector<std::string> names;
  for (const auto& [name, title] : kShown)
    if (has_figure(results, name)) names.push_back(name);
  for (const std::string& name : figure_names(results))
    if (names.size() < 8 && std::find(names.begin(), names.end(), name) == names.end() && name != "time_s")
      names.push_back(name);
  std::vector<Column> columns{{"case"}};
  for (const std::string& setting : results.settings) columns.push_back({setting});
  columns.insert(columns.end(), {{"state"}, {"CPU", Column::Kind::number}, {"time [s]", Column::Kind::number}});
  for (const std::string& name : names) columns.push_back({name, Column::Kind::number});
  std::vector<std::vector<std::string>> rows;
  for (const CaseResult& one : results.cases) {
    std::vector<std::string> row{one.name};
    row.insert(row.end(), one.values.begin(), one.values.end());
    row.insert(row.end(), {one.state, report::duration(one.cpu), report::number(figure_of(one, "time_s"))});
    for (const std::string& name : names) row.push_back(report::number(figure_of(one, name)));
    rows.push_back(std::move(row));
  }
  return report::table(columns, rows);
}

std::vector<report::Figure> figures_over_setting(const SweepResults& results) {
  std::vector<report::Figure> figures;
  for (const auto& [name, title] : kShown)
    if (has_figure(results, name)) figures.push_back(over_setting(results, name, title));
  return figures;
}

std::vector<report::Figure> figures_over_time(const SweepResults& results) {
  std::vector<report::Figure> figures;
  for (const auto& [name, title] : kShown)
    if (has_curve(results, name)) figures.push_back(over_time(results, name, title));
  return figures;
}

}  // namespace

Status write_figures(const SweepResults& results, report::Plotter& plotter, const fs::path& folder,
                     const std::string& prefix) {
  std::vector<report::Plot> plots;
  for (const auto& figures : {figures_over_setting(results), figures_over_time(results)})
    for (const report::Figure& figure : figures)
      if (!figure.plot.script.empty()) plots.push_back(figure.plot);
  GRANARY_TRY(const auto drawn, plotter.draw(plots));
  GRANARY_CHECK(make_folders(folder));
  for (std::size_t i = 0; i < plots.size(); ++i)
    GRANARY_CHECK(write_text_atomically(folder / (prefix + plots[i].id + ".svg"), report::as_file(drawn[i])));
  return {};
}

Result<std::string> page(const SweepResults& results, report::Plotter& plotter) {
  double cpu = 0.0;
  long finished = 0;
  for (const CaseResult& one : results.cases) cpu += one.cpu, finished += one.state == "finished";
  const std::string header =
      fmt::format("<header>\n<h1>{}</h1>\n{}{}</header>\n", report::escaped(results.name),
                  results.description.empty() ? "" : "<p>" + report::escaped(results.description) + "</p>\n",
                  report::soft(fmt::format("sweep of {} · Granary {}", results.solver == "dem" ? "a DEM" : "a PBM",
                                           results.version)));
  const std::string cards = "<div class=\"cards\">\n" + report::card(std::to_string(results.cases.size()), "cases") +
                            report::card(std::to_string(finished), "finished") +
                            report::card(report::duration(cpu), "CPU time of all") + "</div>\n";
  return report::page_html({results.name + " – Granary sweep",
                            header,
                            cards,
                            {{"cases", "Cases", "Cases", report::panel(table_of(results)), {}},
                             {"settings", "What the settings do", "Settings", "", figures_over_setting(results)},
                             {"time", "Over time", "Time", "", figures_over_time(results)}}},
                           plotter);
}

Status write_results(const SweepResults& results, const fs::path& dir, bool with_page) {
  GRANARY_CHECK(json::write_file(dir / "sweep.json", to_json(results)));
  GRANARY_CHECK(write_text_atomically(dir / "sweep.csv", to_csv(results)));
  GRANARY_CHECK(write_h5(results, dir / "results.h5"));
  if (!with_page) return {};
  report::GnuplotPlotter gnuplot;
  GRANARY_TRY(const std::string html, page(results, gnuplot));
  return write_text_atomically(dir / "report.html", html);
}

}  // namespace granary::sweep
