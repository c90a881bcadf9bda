#include "controller/estimation/evaluation_log.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace granary::estimating {
namespace {

namespace fs = std::filesystem;
using estimation::Estimator;
using estimation::Outcome;
using estimation::Problem;
using estimation::Trial;
using json::Value;

Outcome outcome_of(const Value& line, const Problem& problem) {
  Outcome outcome;
  outcome.model = line.numbers("model");
  estimation::Fit fit = estimation::fit_of(problem, outcome.model, line.numbers("values"));
  outcome.residuals = std::move(fit.residuals);
  outcome.held_out = std::move(fit.held_out);
  return outcome;
}

/// Runs an estimator through the lines once more. A log that another revision wrote may ask for other trials: then only
/// what the last version's trials found is kept.
class Replay {
 public:
  Replay(fs::path folder, estimation::Settings settings, EvaluationLog::Past& past)
      : folder_(std::move(folder)), settings_(settings), past_(past) {}

  Status line(const Value& line) {
    if (line.find("problem") != nullptr) return problem(static_cast<int>(line.integer_or("problem", 0)));
    if (!past_.estimator) return Error{"a problem is expected before it"};
    if (line.find("batch") != nullptr) return batch(line);
    if (line.find("trial") != nullptr) return trial(line);
    return Error{"it is no problem, no batch and no trial"};
  }

  void finish() {
    if (same_trials_ || !past_.estimator) return;
    past_.estimator = std::make_unique<Estimator>(past_.estimator->problem(), settings_, past_.estimator->version());
    past_.waiting.clear();
    for (const auto& [values, outcome] : results_) past_.estimator->inform(values, outcome);
  }

 private:
  Status problem(int version) {
    const fs::path file = problem_file(folder_, version);
    GRANARY_TRY(const Value document, json::read_file(file));
    GRANARY_TRY(Problem problem, estimation::read_problem(document, file.string()));
    if (past_.estimator)
      past_.estimator->change(std::move(problem), version);
    else
      past_.estimator = std::make_unique<Estimator>(std::move(problem), settings_, version);
    past_.waiting.clear();
    results_.clear();
    return {};
  }

  Status batch(const Value& line) {
    const int number = static_cast<int>(line.integer_or("batch", 0));
    past_.batches = std::max(past_.batches, number);
    const auto count = static_cast<int>(line.integer_or("count", 0));
    std::vector<Trial> trials = past_.estimator->ask(count);
    same_trials_ &= static_cast<int>(trials.size()) == count && !trials.empty() &&
                    trials.front().number == line.integer_or("first", -1);
    past_.waiting[number] = std::move(trials);
    return {};
  }

  Status trial(const Value& line) {
    if (line.integer_or("version", 0) != past_.estimator->version()) return {};
    const long number = line.integer_or("trial", -1);
    const Trial* trial = taken(number);
    const std::vector<double> values = line.numbers("values");
    same_trials_ &= trial != nullptr && past_.estimator->values_of(*trial) == values;
    past_.seconds += line.number_or("seconds", 0.0);
    if (line.find("model") == nullptr) {
      past_.estimator->tell(number, std::nullopt);
      return {};
    }
    const Outcome outcome = outcome_of(line, past_.estimator->problem());
    past_.last_seconds = line.number_or("seconds", 0.0);
    past_.estimator->tell(number, outcome);
    results_.emplace_back(values, outcome);
    return {};
  }

  /// The trial of that number, out of its batch. Points to itself until the next call.
  const Trial* taken(long number) {
    for (auto batch = past_.waiting.begin(); batch != past_.waiting.end(); ++batch) {
      auto& trials = batch->second;
      const auto it = std::find_if(trials.begin(), trials.end(), [&](const Trial& t) { return t.number == number; });
      if (it == trials.end()) continue;
      taken_ = *it;
      trials.erase(it);
      if (trials.empty()) past_.waiting.erase(batch);
      return &taken_;
    }
    return nullptr;
  }

  fs::path folder_;
  estimation::Settings settings_;
  EvaluationLog::Past& past_;
  bool same_trials_ = true;
  std::vector<std::pair<std::vector<double>, Outcome>> results_;  ///< of this version
  Trial taken_;
};

}  // namespace

fs::path problem_file(const fs::path& folder, int version) {
  return folder / fmt::format("problem-{:04}.json", version);
}

Result<EvaluationLog> EvaluationLog::open(const fs::path& folder, const estimation::Settings& settings, Past& past) {
  const fs::path file = folder / "evaluations.jsonl";
  json::LineReader reader(file);
  GRANARY_TRY(const std::vector<Value> lines, reader.next());
  if (reader.torn_bytes() > 0) {
    std::error_code failed;
    fs::resize_file(file, fs::file_size(file, failed) - reader.torn_bytes(), failed);
    if (failed)
      return Error{fmt::format("{}: its torn last line cannot be cut off: {}.", file.string(), failed.message())};
  }
  Replay replay(folder, settings, past);
  for (std::size_t k = 0; k < lines.size(); ++k)
    if (const Status understood = replay.line(lines[k]); !understood)
      return Error{
          fmt::format("{}: line {} cannot be understood: {}.", file.string(), k + 1, understood.error().message)};
  replay.finish();
  GRANARY_TRY(json::LineWriter writer, json::LineWriter::append_to(file));
  return EvaluationLog(std::move(writer));
}

Status EvaluationLog::problem(int version) { return lines_.append(Value::object({{"problem", version}})); }

Status EvaluationLog::batch(int number, const std::vector<Trial>& trials) {
  return lines_.append(
      Value::object({{"batch", number}, {"first", std::int64_t{trials.front().number}}, {"count", trials.size()}}));
}

Status EvaluationLog::trial(int version, long number, const std::vector<double>& values, const Outcome& outcome,
                            const std::string& failed, double seconds, double time) {
  Value line = Value::object({{"version", version}, {"trial", std::int64_t{number}}, {"values", values}});
  if (failed.empty())
    line.set("cost", estimation::cost_of(outcome.residuals)).set("model", outcome.model);
  else
    line.set("cost", Value()).set("failed", failed);
  return lines_.append(line.set("seconds", seconds).set("time_s", time));
}

}  // namespace granary::estimating
