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

/// A figure over the last of the settings; a line for each combination of the others.
struct FigureLines {
  struct Points {
    std::map<double, Spread> ours;
    std::map<double, double> reference;
  };
  std::map<std::string, Points> lines;
  std::vector<std::string> order;
  std::vector<double> x;
};

/// Nothing if the last setting is not a number.
std::optional<FigureLines> lines_of(const SweepResults& results, const std::string& name) {
  FigureLines all;
  const auto others = [](const std::vector<std::string>& values) {
    return fmt::format("{}", fmt::join(values.begin(), values.end() - 1, ", "));
  };
  for (const Repeats& repeats : repeats_of(results)) {
    const auto x = leading_number(repeats.values.back());
    if (!x) return std::nullopt;
    const auto [line, fresh] = all.lines.try_emplace(others(repeats.values));
    if (fresh) all.order.push_back(line->first);
    line->second.ours[*x] = spread_of(repeats, name);
    if (std::find(all.x.begin(), all.x.end(), *x) == all.x.end()) all.x.push_back(*x);
  }
  for (const Reference& one : results.reference)
    all.lines[others(one.values)].reference[*leading_number(one.values.back())] = figure_of(one.figures, name);
  std::sort(all.x.begin(), all.x.end());
  return all;
}

report::Figure over_setting(const SweepResults& results, const std::string& name, const std::string& title) {
  const std::string id = plot_id("setting", name);
  const auto conditions = conditions_of(results);
  if (conditions.empty()) return {title, "", {id, 620, 360, ""}, "nothing was swept"};
  const auto all = lines_of(results, name);
  if (!all) return {title, "", {id, 620, 360, ""}, "its setting is not a number"};
  if (all->x.size() < 2) return {title, "", {id, 620, 360, ""}, "the last setting has one value only"};
  LinePlot plot;
  plot.x_title = conditions.back();
  plot.y_title = title;
  plot.with_points = true;
  plot.x = all->x;
  for (std::size_t i = 0; i < all->order.size(); ++i) {
    const auto& [ours, reference] = all->lines.at(all->order[i]);
    const std::string colour = report::sequence_colour(i, all->order.size());
    std::vector<double> mean, low, high, theirs;
    for (const double x : plot.x) {
      const auto at = ours.find(x);
      const Spread spread = at == ours.end() ? Spread{} : at->second;
      mean.push_back(spread.mean);
      low.push_back(spread.mean - spread.scatter);
      high.push_back(spread.mean + spread.scatter);
      theirs.push_back(reference.count(x) == 1 ? reference.at(x) : std::nan(""));
    }
    plot.bands.push_back({"", colour, std::move(low), std::move(high)});
    plot.lines.push_back(
        {i < kMostLegends ? report::shortened(all->order[i], 32) : "", colour, std::move(mean), false});
    if (!report::has_numbers(theirs)) continue;
    plot.lines.push_back({"", colour, std::move(theirs), true});
  }
  std::string note = "At the end of each case.";
  if (results.seed) note += " Lines: means over seeds; shaded: one standard deviation.";
  if (!results.reference.empty()) note += " Dashed: the reference.";
  return {title, note, {id, 620, 360, report::line_plot_script(plot)}, "no case has it"};
}

std::string with_scatter(const Spread& spread) {
  if (!std::isfinite(spread.scatter)) return report::number(spread.mean);
  return fmt::format("{} ± {}", report::number(spread.mean), report::number(spread.scatter));
}

std::vector<std::string> names_shown(const SweepResults& results) {
  std::vector<std::string> names;
  for (const auto& [name, title] : kShown)
    if (has_figure(results, name)) names.push_back(name);
  for (const std::string& name : figure_names(results))
    if (names.size() < 8 && std::find(names.begin(), names.end(), name) == names.end() && name != "time_s")
      names.push_back(name);
  return names;
}

/// Mean and scatter over seeds; "" if nothing was repeated.
std::string means_table(const SweepResults& results) {
  if (!results.seed) return "";
  const std::vector<std::string> names = names_shown(results);
  std::vector<Column> columns;
  for (const std::string& setting : conditions_of(results)) columns.push_back({setting});
  columns.push_back({"cases", Column::Kind::number});
  for (const std::string& name : names) columns.push_back({name, Column::Kind::number});
  std::vector<std::vector<std::string>> rows;
  for (const Repeats& repeats : repeats_of(results)) {
    std::vector<std::string> row = repeats.values;
    row.push_back(std::to_string(repeats.cases.size()));
    for (const std::string& name : names) row.push_back(with_scatter(spread_of(repeats, name)));
    rows.push_back(std::move(row));
  }
  return report::panel(report::table(columns, rows));
}

/// Ours and theirs, where there is both; "" without a reference.
std::string reference_table(const SweepResults& results) {
  std::vector<std::string> names;
  for (const Reference& one : results.reference)
    for (const Figure& figure : one.figures)
      if (std::find(names.begin(), names.end(), figure.name) == names.end()) names.push_back(figure.name);
  if (names.empty()) return "";
  std::vector<Column> columns;
  for (const std::string& setting : conditions_of(results)) columns.push_back({setting});
  columns.push_back({"time [s]", Column::Kind::number});
  for (const std::string& name : names)
    columns.insert(
        columns.end(),
        {{name, Column::Kind::number}, {"reference", Column::Kind::number}, {"difference", Column::Kind::number}});
  std::vector<std::vector<std::string>> rows;
  const auto repeats = repeats_of(results);
  for (const Reference& one : results.reference) {
    const auto ours =
        std::find_if(repeats.begin(), repeats.end(), [&](const Repeats& r) { return r.values == one.values; });
    std::vector<std::string> row = one.values;
    row.push_back(report::number(spread_of(*ours, "time_s").mean));
    for (const std::string& name : names) {
      const Spread spread = spread_of(*ours, name);
      const double theirs = figure_of(one.figures, name);
      row.insert(row.end(), {with_scatter(spread), report::number(theirs), report::number(spread.mean - theirs)});
    }
    rows.push_back(std::move(row));
  }
  return report::panel(report::table(columns, rows));
}

std::string table_of(const SweepResults& results) {
  const std::vector<std::string> names = names_shown(results);
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
  std::vector<report::Figure> figures = figures_over_setting(results);
  for (report::Figure& figure : figures_over_time(results)) figures.push_back(std::move(figure));
  return report::write_figures(figures, plotter, folder, prefix);
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
  std::vector<report::Section> sections{{"cases", "Cases", "Cases", report::panel(table_of(results)), {}}};
  if (const std::string table = means_table(results); !table.empty())
    sections.push_back({"means", "Means and scatter over seeds", "Means", table, {}});
  if (const std::string table = reference_table(results); !table.empty())
    sections.push_back({"reference", "Beside the reference", "Reference", table, {}});
  sections.push_back({"settings", "What the settings do", "Settings", "", figures_over_setting(results)});
  sections.push_back({"time", "Over time", "Time", "", figures_over_time(results)});
  return report::page_html({results.name + " – Granary sweep", header, cards, std::move(sections)}, plotter);
}

Status write_results(const SweepResults& results, const fs::path& dir, bool with_page) {
  GRANARY_CHECK(json::write_file(dir / "sweep.json", to_json(results)));
  GRANARY_CHECK(write_text_atomically(dir / "sweep.csv", to_csv(results)));
  if (results.seed) GRANARY_CHECK(write_text_atomically(dir / "sweep_means.csv", means_csv(results)));
  GRANARY_CHECK(write_h5(results, dir / "results.h5"));
  if (!with_page) return {};
  report::GnuplotPlotter gnuplot;
  GRANARY_TRY(const std::string html, page(results, gnuplot));
  return write_text_atomically(dir / "report.html", html);
}

}  // namespace granary::sweep
