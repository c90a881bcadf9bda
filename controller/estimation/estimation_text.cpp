#include "controller/estimation/estimation_text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace granary::estimating {

using json::Value;

namespace {

/// One row a number that was measured: each share of a distribution is one.
Value fit_of(const estimation::Problem& problem, const std::vector<double>& model) {
  Value rows = Value::array();
  auto computed = model.begin();
  for (const estimation::Target& t : problem.targets)
    for (std::size_t k = 0; k < t.size() && computed != model.end(); ++k) {
      const bool share = t.quantity == estimation::Quantity::distribution;
      Value row = estimation::to_json(t);
      std::erase_if(row.members(), [](const json::Member& m) {
        return m.first == "edges" || m.first == "shares" || m.first == "value" || m.first == "weight";
      });
      if (share) row.set("from", t.edges[k]).set("to", t.edges[k + 1]);
      rows.push(row.set("measured", share ? t.shares[k] : t.value).set("model", *computed++));
    }
  return rows;
}

const campaign::Estimation::Parameter& named(const campaign::Estimation& estimation, const std::string& name) {
  return *std::find_if(estimation.parameters.begin(), estimation.parameters.end(),
                       [&](const auto& p) { return p.is.name == name; });
}

std::string parameter_line(const Value& p, const campaign::Estimation& estimation) {
  const auto& parameter = named(estimation, p["name"].as_string());
  const auto shown = [&](double value) { return campaign::shown(value, parameter.unit); };
  const std::string interval =
      p.find("low") == nullptr ? "not known yet"
                               : fmt::format("{} .. {}{}", shown(p["low"].as_number()), shown(p["high"].as_number()),
                                             p["at_bound"].as_bool() ? " (ends at a bound)" : "");
  return fmt::format("  {:<28} {:>14}   {}\n", p["name"].as_string(), shown(p["value"].as_number()), interval);
}

}  // namespace

std::string progress_text(const Crew& crew, const campaign::Estimation& estimation) {
  const estimation::Estimator& estimator = crew.estimator();
  std::string text = fmt::format("{}: {} evaluations", estimation::name_of(estimator.phase()), estimator.evaluated());
  const auto best = crew.best();
  if (!best) return text;
  text += fmt::format(", half the sum of squares {:.4g}", best->cost);
  for (std::size_t k = 0; k < best->values.size(); ++k)
    text += fmt::format(", {} {}", estimation.parameters[k].is.name,
                        campaign::shown(best->values[k], estimation.parameters[k].unit));
  return text;
}

Value report_json(const Crew& crew, const estimation::Problem& problem, const pilot::Usage& usage, double wall,
                  const std::filesystem::path& dir) {
  Value report = crew.status();
  const double evaluated = static_cast<double>(crew.estimator().evaluated());
  return report.set("fit", fit_of(problem, report.numbers("model")))
      .set("wall_s", wall)
      .set("core_use", usage.total > 0.0 ? usage.busy / usage.total : 0.0)
      .set("evaluations_per_s", wall > 0.0 ? evaluated / wall : 0.0)
      .set("dir", dir.string());
}

std::string report_text(const Value& report, const campaign::Estimation& estimation) {
  if (report["parameters"].size() == 0) return "no evaluation succeeded: see estimation/evaluations.jsonl\n";
  std::string text = fmt::format("  {:<28} {:>14}   {}\n", "parameter", "estimate", "95 % interval");
  for (const Value& p : report["parameters"].items()) text += parameter_line(p, estimation);
  for (const char* kind : {"unidentified", "doubts"})
    for (const Value& warning : report[kind].items()) text += fmt::format("! {}\n", warning.as_string());
  text += fmt::format("fit: chi^2 per datum {:.3g}\n", report["chi_square_per_datum"].as_number());
  if (!report["held_out_mean_square"].is_null())
    text += fmt::format("held-out data: mean square {:.3g} of their errors (about 1 if they are predicted)\n",
                        report["held_out_mean_square"].as_number());
  text += fmt::format("intervals: {}\n", report["intervals"].as_string());
  return text + fmt::format("{} evaluations ({} failed) in {:.1f} s, {:.0f} a second; core use {:.0f} %\nreport: {}\n",
                            report["evaluated"].as_integer(), report["failed"].as_integer(),
                            report["wall_s"].as_number(), report["evaluations_per_s"].as_number(),
                            100.0 * report["core_use"].as_number(),
                            (std::filesystem::path(report["dir"].as_string()) / "estimation" / "report.json").string());
}

}  // namespace granary::estimating
