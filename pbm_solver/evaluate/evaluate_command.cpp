#include "pbm_solver/evaluate/evaluate_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <vector>

#include "common/json/io.hpp"
#include "common/json/reader.hpp"
#include "pbm_solver/evaluate/experiment_model.hpp"

namespace granary::pbm {
namespace {

using json::Value;

struct TrialLine {
  std::int64_t number = 0;
  std::vector<double> values;
};

struct TrialList {
  double seconds_at_most = 1e300;  ///< of CPU time, each
  std::vector<TrialLine> trials;
};

Result<TrialList> read_trials(const std::filesystem::path& file, std::size_t n_parameters) {
  GRANARY_TRY(const Value document, json::read_file(file));
  json::Problems problems;
  json::Reader reader(document, file.string(), problems);
  TrialList list;
  reader.integer_or("problem", 1);  // its version: for people
  list.seconds_at_most = reader.number_or("seconds_at_most", list.seconds_at_most, json::Range::positive());
  for (json::Reader& item : reader.items("trials")) {
    list.trials.push_back({item.integer("number"), item.numbers("values")});
    if (list.trials.back().values.size() != n_parameters)
      item.problem("values",
                   fmt::format("{} values for {} parameters.", list.trials.back().values.size(), n_parameters));
    item.done();
  }
  reader.done();
  if (!problems.empty()) return problems.error();
  return list;
}

double seconds_now() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Value line_of(const ExperimentModel& model, const TrialLine& trial, double seconds_at_most) {
  const double began = seconds_now();
  const auto computed = model.run(trial.values, seconds_at_most);
  Value line = Value::object({{"trial", trial.number}});
  if (!computed) {
    line.set("failed", computed.error().message);
  } else if (!std::all_of(computed->begin(), computed->end(), [](double v) { return std::isfinite(v); })) {
    line.set("failed", "a target's value is not finite");
  } else {
    const estimation::Fit fit = estimation::fit_of(model.problem(), *computed, trial.values);
    line.set("residuals", fit.residuals).set("held_out", fit.held_out).set("model", *computed);
  }
  return line.set("seconds", seconds_now() - began);
}

}  // namespace

CLI::App* add_evaluate_command(CLI::App& app, EvaluateOptions& options) {
  CLI::App* command = app.add_subcommand("evaluate", "how well sets of parameters fit (docs/exchange_formats.md)");
  command->add_option("PROBLEM", options.problem, "parameters, experiments and targets, a JSON file")->required();
  command->add_option("TRIALS", options.trials, "the sets of parameters, a JSON file")->required();
  command->add_option("--out", options.out, "the file of lines to write")->required();
  return command;
}

Status evaluate(const EvaluateOptions& options) {
  GRANARY_TRY(const Value document, json::read_file(options.problem));
  GRANARY_TRY(estimation::Problem problem, estimation::read_problem(document, options.problem.string()));
  GRANARY_TRY(const ExperimentModel model, ExperimentModel::prepare(std::move(problem), options.problem.string()));
  GRANARY_TRY(const TrialList list, read_trials(options.trials, model.problem().parameters.size()));
  GRANARY_TRY(json::LineWriter out, json::LineWriter::create(options.out));
  for (const TrialLine& trial : list.trials) GRANARY_CHECK(out.append(line_of(model, trial, list.seconds_at_most)));
  return out.append(Value::object({{"done", true}}));
}

}  // namespace granary::pbm
