#include "controller/sweep/results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "common/json/io.hpp"
#include "common/results/hdf5_file.hpp"

namespace granary::sweep {
namespace {

namespace fs = std::filesystem;

/// Quoted where a comma, a quote or a line break would be misread.
std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

Status write_table(const SweepResults& results, Hdf5File& file) {
  std::vector<std::string> names, states;
  for (const CaseResult& one : results.cases) names.push_back(one.name), states.push_back(one.state);
  GRANARY_CHECK(file.write_texts("/sweep/case", names, "name of each case: of its folder"));
  GRANARY_CHECK(file.write_texts("/sweep/state", states, "what became of its task"));
  for (std::size_t k = 0; k < results.settings.size(); ++k) {
    std::vector<std::string> values;
    for (const CaseResult& one : results.cases) values.push_back(one.values[k]);
    GRANARY_CHECK(file.write_texts(fmt::format("/sweep/setting/{:04}", k + 1), values, results.settings[k]));
  }
  const auto column = [&](const std::string& name, const auto& value_of, const std::string& unit,
                          const std::string& what) {
    DataArray data{{results.cases.size()}, {}};
    for (const CaseResult& one : results.cases) data.values.push_back(value_of(one));
    return file.write(name, data, unit, what);
  };
  GRANARY_CHECK(column(
      "/sweep/wall", [](const CaseResult& one) { return one.wall; }, "s", "wall time"));
  GRANARY_CHECK(column(
      "/sweep/cpu", [](const CaseResult& one) { return one.cpu; }, "s", "CPU time"));
  for (const std::string& name : figure_names(results))
    GRANARY_CHECK(column(
        "/sweep/figure/" + name, [&](const CaseResult& one) { return figure_of(one, name); }, unit_of(name),
        "at the end of each case"));
  return {};
}

Status write_curves(const CaseResult& one, Hdf5File& file) {
  for (const Curve& curve : one.curves) {
    const std::string at = fmt::format("/curve/{}/{}", one.name, curve.name);
    GRANARY_CHECK(file.write(at + "/time", {{curve.time.size()}, curve.time}, "s", "time"));
    GRANARY_CHECK(file.write(at + "/value", {{curve.value.size()}, curve.value}, unit_of(curve.name), curve.name));
  }
  return {};
}

}  // namespace

std::string unit_of(const std::string& name) {
  const auto bar = name.find('[');
  const std::string plain = name.substr(0, bar);
  for (const char* unit : {"1_s", "kg_s", "m3", "m", "s", "J", "W", "Pa", "kg"})
    if (plain.ends_with(std::string("_") + unit)) {
      const std::string text = unit;
      return text == "1_s" ? "1/s" : text == "kg_s" ? "kg/s" : text == "m3" ? "m^3" : text;
    }
  return "1";
}

double figure_of(const std::vector<Figure>& figures, const std::string& name) {
  for (const Figure& figure : figures)
    if (figure.name == name) return figure.value;
  return std::numeric_limits<double>::quiet_NaN();
}

const Curve* curve_of(const CaseResult& one, const std::string& name) {
  const auto found =
      std::find_if(one.curves.begin(), one.curves.end(), [&](const Curve& curve) { return curve.name == name; });
  return found == one.curves.end() ? nullptr : &*found;
}

std::vector<std::string> figure_names(const SweepResults& results) {
  std::vector<std::string> names;
  for (const CaseResult& one : results.cases)
    for (const Figure& figure : one.figures)
      if (std::find(names.begin(), names.end(), figure.name) == names.end()) names.push_back(figure.name);
  return names;
}

std::string text_of(const json::Value& value) {
  return value.is_null() ? "" : value.is_string() ? value.as_string() : json::dump(value);
}

std::optional<double> leading_number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end == text.c_str()) return std::nullopt;
  return value;
}

std::vector<std::string> conditions_of(const SweepResults& results) {
  std::vector<std::string> names = results.settings;
  if (results.seed) names.erase(names.begin() + static_cast<std::ptrdiff_t>(*results.seed));
  return names;
}

std::vector<Repeats> repeats_of(const SweepResults& results) {
  std::vector<Repeats> all;
  for (const CaseResult& one : results.cases) {
    if (one.figures.empty()) continue;
    std::vector<std::string> values = one.values;
    if (results.seed) values.erase(values.begin() + static_cast<std::ptrdiff_t>(*results.seed));
    auto same = results.seed
                    ? std::find_if(all.begin(), all.end(), [&](const Repeats& r) { return r.values == values; })
                    : all.end();
    if (same == all.end()) same = all.insert(all.end(), {std::move(values), {}});
    same->cases.push_back(&one);
  }
  return all;
}

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  double sum = 0.0, squares = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) sum += value, ++spread.n;
  if (spread.n == 0) return spread;
  const auto n = static_cast<double>(spread.n);
  spread.mean = sum / n;
  for (const double value : values)
    if (std::isfinite(value)) squares += (value - spread.mean) * (value - spread.mean);
  if (spread.n > 1) spread.scatter = std::sqrt(squares / (n - 1.0));
  return spread;
}

Spread spread_of(const Repeats& repeats, const std::string& figure) {
  std::vector<double> values;
  for (const CaseResult* one : repeats.cases) values.push_back(figure_of(*one, figure));
  return spread_of(values);
}

namespace {

json::Value conditions_json(const SweepResults& results, const std::vector<std::string>& values) {
  json::Value settings = json::Value::object();
  const auto names = conditions_of(results);
  for (std::size_t k = 0; k < names.size(); ++k) settings.set(names[k], values[k]);
  return settings;
}

json::Value means_json(const SweepResults& results) {
  json::Value means = json::Value::array();
  for (const Repeats& repeats : repeats_of(results)) {
    json::Value figures = json::Value::object();
    for (const std::string& name : figure_names(results)) {
      const Spread spread = spread_of(repeats, name);
      figures.set(name, json::Value::object({{"mean", spread.mean},
                                             {"scatter", spread.scatter},
                                             {"cases", static_cast<std::int64_t>(spread.n)}}));
    }
    means.push(
        json::Value::object({{"settings", conditions_json(results, repeats.values)}, {"figures", std::move(figures)}}));
  }
  return means;
}

json::Value reference_json(const SweepResults& results) {
  json::Value reference = json::Value::array();
  for (const Reference& one : results.reference) {
    json::Value figures = json::Value::object();
    for (const Figure& figure : one.figures) figures.set(figure.name, figure.value);
    reference.push(
        json::Value::object({{"settings", conditions_json(results, one.values)}, {"figures", std::move(figures)}}));
  }
  return reference;
}

}  // namespace

json::Value to_json(const SweepResults& results) {
  json::Value cases = json::Value::array();
  for (const CaseResult& one : results.cases) {
    json::Value settings = json::Value::object(), figures = json::Value::object();
    for (std::size_t k = 0; k < results.settings.size(); ++k) settings.set(results.settings[k], one.values[k]);
    for (const Figure& figure : one.figures) figures.set(figure.name, figure.value);
    cases.push(json::Value::object({{"name", one.name},
                                    {"settings", std::move(settings)},
                                    {"state", one.state},
                                    {"wall_s", one.wall},
                                    {"cpu_s", one.cpu},
                                    {"figures", std::move(figures)}}));
  }
  json::Value all = json::Value::object({{"format", "granary-sweep-1"},
                                         {"name", results.name},
                                         {"solver", results.solver},
                                         {"version", results.version},
                                         {"settings", results.settings},
                                         {"cases", std::move(cases)}});
  if (results.seed) all.set("means", means_json(results));
  if (!results.reference.empty()) all.set("reference", reference_json(results));
  return all;
}

std::string to_csv(const SweepResults& results) {
  const auto names = figure_names(results);
  std::string text = "case";
  for (const std::string& setting : results.settings) text += "," + csv_cell(setting);
  text += ",state,wall_s,cpu_s";
  for (const std::string& name : names) text += "," + csv_cell(name);
  text += "\n";
  for (const CaseResult& one : results.cases) {
    text += one.name;
    for (const std::string& value : one.values) text += "," + csv_cell(value);
    text += fmt::format(",{},{},{}", one.state, csv_number(one.wall), csv_number(one.cpu));
    for (const std::string& name : names) text += "," + csv_number(figure_of(one, name));
    text += "\n";
  }
  return text;
}

std::string means_csv(const SweepResults& results) {
  const auto names = figure_names(results);
  std::string text;
  for (const std::string& setting : conditions_of(results)) text += csv_cell(setting) + ",";
  text += "cases";
  for (const std::string& name : names) text += fmt::format(",{0},{0}_scatter", csv_cell(name));
  text += "\n";
  for (const Repeats& repeats : repeats_of(results)) {
    for (const std::string& value : repeats.values) text += csv_cell(value) + ",";
    text += std::to_string(repeats.cases.size());
    for (const std::string& name : names) {
      const Spread spread = spread_of(repeats, name);
      text += fmt::format(",{},{}", csv_number(spread.mean), csv_number(spread.scatter));
    }
    text += "\n";
  }
  return text;
}

Status write_h5(const SweepResults& results, const fs::path& file) {
  const fs::path beside = file.string() + ".new";
  {
    GRANARY_TRY(Hdf5File h5, Hdf5File::create(beside));
    GRANARY_CHECK(h5.attribute("/", "format", "granary-sweep-1"));
    GRANARY_CHECK(h5.attribute("/", "name", results.name));
    GRANARY_CHECK(h5.attribute("/", "solver", results.solver));
    GRANARY_CHECK(h5.attribute("/", "version", results.version));
    GRANARY_CHECK(write_table(results, h5));
    for (const CaseResult& one : results.cases) GRANARY_CHECK(write_curves(one, h5));
    GRANARY_CHECK(h5.flush());
  }
  std::error_code code;
  fs::rename(beside, file, code);
  if (code) return Error{fmt::format("{}: cannot be replaced: {}.", file.string(), code.message()), Exit::task_failed};
  return {};
}

}  // namespace granary::sweep
