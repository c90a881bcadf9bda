#include "controller/sweep/outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/json/io.hpp"
#include "common/version.hpp"
#include "controller/campaign/data_file.hpp"
#include "controller/sweep/cases.hpp"

namespace granary::sweep {
namespace {

namespace fs = std::filesystem;
using campaign::Sweep;
using campaign::SweepCase;

/// Of the program, not of the process it computes.
bool is_bookkeeping(const std::string& name) {
  static const std::set<std::string> known{"time_s", "step",     "steps",           "wall_s",  "cpu_s",
                                           "step_s", "rejected", "rhs_evaluations", "window_s"};
  return known.count(name) == 1;
}

/// Numbers of one line by name.
void flatten(const json::Value& value, const std::string& name, std::vector<Figure>& into) {
  if (value.is_number() || value.is_null()) {
    into.push_back({name, value.is_null() ? std::nan("") : value.as_number()});
  } else if (value.is_object()) {
    for (const auto& [key, member] : value.members()) flatten(member, name + "." + key, into);
  } else if (value.is_array()) {
    const auto& items = value.items();
    const bool plain = std::all_of(items.begin(), items.end(),
                                   [](const json::Value& item) { return item.is_number() || item.is_null(); });
    for (std::size_t i = 0; plain && i < items.size(); ++i)
      flatten(items[i], items.size() == 1 ? name : fmt::format("{}[{}]", name, i + 1), into);
  }
}

/// Whole lines only: a file that is still written, or was cut, ends in the middle of one. None if there is no file.
Result<std::vector<json::Value>> lines_of(const fs::path& file) { return json::LineReader(file).next(); }

/// Sums of what tallies.jsonl counts in each window, per time: [1/s].
std::vector<Curve> tally_curves(const std::vector<json::Value>& lines) {
  Curve collisions{"collisions_1_s", {}, {}}, energy{"kinetic_energy_J", {}, {}};
  std::map<std::string, Curve> impacts, power;
  for (const json::Value& line : lines) {
    const double time = line.number_or("time_s", std::nan("")), window = line.number_or("window_s", 0.0);
    if (!(window > 0.0) || !line["collisions"].is_array()) continue;
    double sum = 0.0;
    const auto& rows = line["collisions"].items();
    for (std::size_t p = 0; p < rows.size(); ++p) {
      const auto row = rows[p].numbers();
      for (std::size_t q = p; q < row.size(); ++q) sum += row[q];
    }
    collisions.time.push_back(time), collisions.value.push_back(sum / window);
    energy.time.push_back(time), energy.value.push_back(line.number_or("kinetic_energy_J", std::nan("")));
    for (const auto& [body, counts] : line["impacts"].members_or_none()) {
      double hits = 0.0;
      for (const double n : counts.numbers()) hits += n;
      Curve& curve = impacts[body];
      curve.name = "impacts_" + body + "_1_s";
      curve.time.push_back(time), curve.value.push_back(hits / window);
    }
    for (const auto& [body, load] : line["loads"].members_or_none()) {
      Curve& curve = power[body];
      curve.name = "power_" + body + "_W";
      curve.time.push_back(time), curve.value.push_back(load.number_or("power_W", std::nan("")));
    }
  }
  std::vector<Curve> curves;
  if (collisions.time.empty()) return curves;
  curves = {std::move(collisions), std::move(energy)};
  for (auto& [body, curve] : impacts) curves.push_back(std::move(curve));
  for (auto& [body, curve] : power) curves.push_back(std::move(curve));
  return curves;
}

double mean_of(const Curve& curve) {
  double sum = 0.0;
  for (const double value : curve.value) sum += value;
  return sum / static_cast<double>(curve.value.size());
}

/// "broken_by_chopper" of all that broke: "share_by_chopper".
void add_shares(CaseResult& one) {
  const std::string by = "broken_by_";
  const double all = figure_of(one, "broken");
  const std::size_t n = one.figures.size();
  for (std::size_t k = 0; k < n; ++k)
    if (const Figure figure = one.figures[k]; figure.name.starts_with(by) && all > 0.0)
      one.figures.push_back({"share_by_" + figure.name.substr(by.size()), figure.value / all});
}

Status read_dem(const fs::path& folder, CaseResult& one) {
  GRANARY_TRY(const auto samples, lines_of(folder / "fragments.jsonl"));
  GRANARY_TRY(const auto breaks, lines_of(folder / "breaks.jsonl"));
  GRANARY_TRY(const auto tallies, lines_of(folder / "tallies.jsonl"));
  one.curves = curves_of(samples);
  if (!one.curves.empty())
    for (Curve& curve : breaks_by_cause(breaks, one.curves.front().time)) one.curves.push_back(std::move(curve));
  for (const Curve& curve : one.curves)
    if (!curve.value.empty()) one.figures.push_back({curve.name, curve.value.back()});
  add_shares(one);
  if (!samples.empty()) one.figures.insert(one.figures.begin(), {"time_s", samples.back().number_or("time_s", 0.0)});
  for (Curve& curve : tally_curves(tallies)) {
    one.figures.push_back({"mean_" + curve.name, mean_of(curve)});
    one.curves.push_back(std::move(curve));
  }
  return {};
}

Status read_pbm(const fs::path& folder, CaseResult& one) {
  GRANARY_TRY(const auto lines, lines_of(folder / "progress.jsonl"));
  one.curves = curves_of(lines);
  if (!lines.empty()) one.figures.push_back({"time_s", lines.back().number_or("time_s", 0.0)});
  for (const Curve& curve : one.curves)
    if (!curve.value.empty()) one.figures.push_back({curve.name, curve.value.back()});
  return {};
}

void add_cost(const pilot::Pilot& pilot, const SweepCase& from, CaseResult& one) {
  one.state = "waiting";
  const auto id = pilot.find(task_name(from));
  if (!id) return;
  // A pilot that only looks back would queue again what had been running.
  const bool over = pilot::has_ended(pilot.state(*id));
  one.state = over ? std::string(pilot::name_of(pilot.state(*id))) : "unfinished";
  if (const auto end = pilot.end(*id)) {
    one.wall = end->end - end->start;
    one.cpu = end->cpu_s;
  }
}

/// "300 rpm" -> 300, "rpm".
std::optional<std::pair<double, std::string>> number_and_unit(const std::string& text) {
  const auto number = leading_number(text);
  if (!number) return std::nullopt;
  const auto at = text.find_first_of(" \t");
  const auto unit = at == std::string::npos ? at : text.find_first_not_of(" \t", at);
  return std::pair{*number, unit == std::string::npos ? std::string("1") : text.substr(unit)};
}

/// The rows of the reference in which this setting has this value.
Result<std::vector<bool>> rows_with(const campaign::CsvFile& csv, const std::string& setting, const std::string& value,
                                    const fs::path& file) {
  const auto wanted = number_and_unit(value);
  if (!wanted)
    return Error{fmt::format("{}: the sweep's setting {} is '{}', no number: a reference cannot be told by it.",
                             file.string(), setting, value)};
  GRANARY_TRY(const auto column, csv.column(setting, wanted->second));
  std::vector<bool> same;
  for (const double x : column.values) same.push_back(std::abs(x - wanted->first) <= 1e-9 * std::abs(wanted->first));
  return same;
}

Result<std::vector<Reference>> read_reference(const fs::path& file, const SweepResults& results) {
  GRANARY_TRY(const auto csv, campaign::CsvFile::read(file));
  const auto conditions = conditions_of(results);
  std::vector<Reference> all;
  for (const Repeats& repeats : repeats_of(results)) {
    std::vector<bool> rows;
    for (std::size_t k = 0; k < conditions.size(); ++k) {
      GRANARY_TRY(const auto same, rows_with(csv, conditions[k], repeats.values[k], file));
      rows.resize(same.size(), true);
      for (std::size_t i = 0; i < same.size(); ++i) rows[i] = rows[i] && same[i];
    }
    const auto at = static_cast<std::size_t>(std::find(rows.begin(), rows.end(), true) - rows.begin());
    if (at == rows.size()) continue;
    Reference one{repeats.values, {}};
    for (const std::string& name : figure_names(results)) {
      if (!csv.has(name)) continue;
      GRANARY_TRY(const auto column, csv.column(name, unit_of(name)));
      if (std::isfinite(column.values[at])) one.figures.push_back({name, column.values[at]});
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace

std::vector<Curve> curves_of(const std::vector<json::Value>& lines) {
  std::vector<Curve> curves;
  std::map<std::string, std::size_t> place;
  for (const json::Value& line : lines) {
    if (!line["time_s"].is_number()) continue;
    const double time = line["time_s"].as_number();
    std::vector<Figure> numbers;
    for (const auto& [key, value] : line.members())
      if (!is_bookkeeping(key)) flatten(value, key, numbers);
    for (const Figure& figure : numbers) {
      const auto [at, fresh] = place.emplace(figure.name, curves.size());
      if (fresh) curves.push_back({figure.name, {}, {}});
      curves[at->second].time.push_back(time);
      curves[at->second].value.push_back(figure.value);
    }
  }
  return curves;
}

std::vector<Curve> breaks_by_cause(const std::vector<json::Value>& breaks, const std::vector<double>& time) {
  std::map<std::string, Curve> by_cause;
  for (const json::Value& line : breaks) {
    Curve& curve = by_cause[line.text_or("cause", "none")];
    if (curve.value.empty()) curve.value.assign(time.size(), 0.0), curve.time = time;
    const double when = line.number_or("time_s", 0.0);
    for (std::size_t i = 0; i < time.size(); ++i)
      if (time[i] >= when * (1.0 - 1e-12)) curve.value[i] += 1.0;
  }
  std::vector<Curve> curves;
  for (auto& [cause, curve] : by_cause) {
    curve.name = "broken_by_" + cause;
    curves.push_back(std::move(curve));
  }
  return curves;
}

Result<SweepResults> collect(const campaign::Campaign& campaign, const fs::path& dir, const pilot::Pilot& pilot) {
  SweepResults results;
  results.name = campaign.name;
  results.description = campaign.description;
  results.solver = campaign.sweep.solver == Sweep::Solver::dem ? "dem" : "pbm";
  results.version = fmt::format("{} ({})", version(), revision());
  for (const Sweep::Setting& setting : campaign.sweep.settings) {
    if (setting.pointer == campaign::kSeedSetting) results.seed = results.settings.size();
    results.settings.push_back(setting.name);
  }
  for (const SweepCase& from : campaign.sweep.cases) {
    CaseResult one;
    one.name = from.name;
    for (const json::Value& value : from.values) one.values.push_back(text_of(value));
    add_cost(pilot, from, one);
    const fs::path folder = dir / folder_of(from);
    GRANARY_CHECK(campaign.sweep.solver == Sweep::Solver::dem ? read_dem(folder, one) : read_pbm(folder, one));
    results.cases.push_back(std::move(one));
  }
  if (campaign.sweep.reference) {
    GRANARY_TRY(results.reference, read_reference(*campaign.sweep.reference, results));
  }
  return results;
}

}  // namespace granary::sweep
