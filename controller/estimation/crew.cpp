#include "controller/estimation/crew.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/files.hpp"
#include "common/json/io.hpp"

namespace granary::estimating {
namespace fs = std::filesystem;
using estimation::Outcome;
using estimation::Phase;
using estimation::Problem;
using estimation::Trial;
using json::Value;

namespace {

// A batch's work beside the 10 ms in which granary-pbm starts. While searching, results are wanted soon; a posterior's
// samples do not wait for each other.
constexpr double kSearchSeconds = 0.2;
constexpr double kPosteriorSeconds = 3.0;
constexpr int kMostTrials = 2000;
constexpr int kMostFruitless = 5;
constexpr int kBadInput = 2;
constexpr double kPatience = 30.0;      // times the usual: an evaluation that takes longer is given up
constexpr double kLeastPatience = 5.0;  // [s]
constexpr double kFirstPatience = 3600.0;
constexpr double kReportEvery = 1.1;  // times as many evaluations

std::string task_name(int batch) { return fmt::format("estimate-{:06}", batch); }

/// What a granary-pbm that refused said last.
std::string last_words(const fs::path& file) {
  auto text = read_text(file);
  return text && !text->empty() ? *std::move(text) : fmt::format("see {}", file.string());
}

/// Whole or not at all for whoever reads it, but without waiting for the disk: all of it can be made again.
Status write_quickly(const fs::path& file, const Value& value) {
  fs::path beside = file;
  beside += ".new";
  GRANARY_TRY(json::LineWriter line, json::LineWriter::create(beside));
  GRANARY_CHECK(line.append(value));
  std::error_code failed;
  fs::rename(beside, file, failed);
  if (failed) return Error{fmt::format("{}: cannot be put in place: {}.", file.string(), failed.message())};
  return {};
}

}  // namespace

Crew::Crew(CrewSettings settings) : settings_(std::move(settings)), folder_(settings_.dir / "estimation") {}

Status Crew::begin(const Problem& problem) {
  GRANARY_CHECK(make_folders(folder_ / "batches"));
  EvaluationLog::Past past;
  GRANARY_TRY(log_, EvaluationLog::open(folder_, settings_.search, past));
  estimator_ = std::move(past.estimator);
  batches_ = past.batches;
  seconds_ = past.seconds;
  each_ = past.last_seconds;
  for (auto& [number, trials] : past.waiting) open_[task_name(number)] = {number, std::move(trials), false};
  if (!estimator_) return set_problem(problem, 1);
  if (json::dump(estimation::to_json(estimator_->problem())) == json::dump(estimation::to_json(problem))) return {};
  const auto stale = change(problem);
  return stale ? Status{} : Status(stale.error());
}

Status Crew::set_problem(const Problem& problem, int version) {
  GRANARY_CHECK(json::write_file(problem_file(folder_, version), estimation::to_json(problem)));
  GRANARY_CHECK(log_->problem(version));
  if (estimator_)
    estimator_->change(problem, version);
  else
    estimator_ = std::make_unique<estimation::Estimator>(problem, settings_.search, version);
  exhausted_ = false;
  return {};
}

Result<std::vector<std::string>> Crew::change(const Problem& problem) {
  GRANARY_CHECK(set_problem(problem, version() + 1));
  std::vector<std::string> names;
  for (const auto& [name, batch] : open_) {
    stale_[name] = batch.number;
    names.push_back(name);
  }
  open_.clear();
  return names;
}

std::vector<std::string> Crew::open() const {
  std::vector<std::string> names;
  for (const auto& [name, batch] : open_) names.push_back(name);
  return names;
}

bool Crew::done() const {
  if (!begun()) return false;
  return (settings_.until_done && estimator_->phase() == Phase::done) || (exhausted_ && open_.empty());
}

Result<std::vector<pilot::TaskSpec>> Crew::next() {
  std::vector<pilot::TaskSpec> tasks;
  if (!begun() || done()) return tasks;
  // One more than the cores, or a few: the next is there when one ends.
  const auto wanted = static_cast<std::size_t>(settings_.cores + 1 + settings_.cores / 8);
  for (std::size_t before = wanted; open_.size() < wanted && open_.size() != before;) {
    before = open_.size();
    GRANARY_CHECK(add_batch());
  }
  for (auto& [name, batch] : open_) {
    if (batch.submitted) continue;
    GRANARY_CHECK(write_trials(batch));
    batch.submitted = true;
    tasks.push_back(task_of(batch));
  }
  return tasks;
}

Status Crew::add_batch() {
  std::vector<Trial> trials = estimator_->ask(trials_for_a_batch());
  exhausted_ = trials.empty() && open_.empty();
  if (trials.empty()) return {};
  const int number = ++batches_;
  GRANARY_CHECK(log_->batch(number, trials));
  open_[task_name(number)] = {number, std::move(trials), false};
  return {};
}

int Crew::trials_for_a_batch() const {
  if (each_ == 0.0) return 1;
  const Phase phase = estimator_->phase();
  const bool sampling = phase == Phase::posterior || phase == Phase::done;
  const double wanted = (sampling ? kPosteriorSeconds : kSearchSeconds) / each_;
  return static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(kMostTrials)));
}

Status Crew::write_trials(const Batch& batch) const {
  Value trials = Value::array();
  for (const Trial& t : batch.trials)
    trials.push(Value::object({{"number", std::int64_t{t.number}}, {"values", estimator_->values_of(t)}}));
  const double patience = each_ > 0.0 ? std::max(kLeastPatience, kPatience * each_) : kFirstPatience;
  return write_quickly(settings_.dir / file_of(batch.number, "trials.json"),
                       Value::object({{"problem", version()}, {"seconds_at_most", patience}, {"trials", trials}}));
}

pilot::TaskSpec Crew::task_of(const Batch& batch) const {
  pilot::TaskSpec task;
  task.name = task_name(batch.number);
  task.command = {settings_.program.string(),
                  "evaluate",
                  problem_file("estimation", version()).string(),
                  file_of(batch.number, "trials.json").string(),
                  "--out",
                  file_of(batch.number, "results.jsonl").string()};
  task.stdout_file = file_of(batch.number, "out");
  task.fill = true;
  return task;
}

fs::path Crew::file_of(int batch, const char* suffix) const {
  return fs::path("estimation") / "batches" / fmt::format("{:06}.{}", batch, suffix);
}

void Crew::remove_files(int batch) const {
  std::error_code ignored;
  for (const char* suffix : {"trials.json", "results.jsonl", "out"})
    fs::remove(settings_.dir / file_of(batch, suffix), ignored);
}

Status Crew::ended(const pilot::TaskEnd& end) {
  if (const auto it = stale_.find(end.name); it != stale_.end()) {
    remove_files(it->second);
    stale_.erase(it);
    return {};
  }
  const auto it = open_.find(end.name);
  // One that was stopped belongs to a campaign that ends: it is run again when that goes on.
  if (it == open_.end() || end.state == pilot::TaskState::stopped) return {};
  Batch batch = std::move(it->second);
  open_.erase(it);
  const bool refused = end.state == pilot::TaskState::failed && end.exit_code == kBadInput;
  const long before = estimator_->evaluated();
  GRANARY_CHECK(take_results(batch, end.end));
  fruitless_ = estimator_->evaluated() > before ? 0 : fruitless_ + 1;
  if (refused || fruitless_ >= kMostFruitless)
    return Error{fmt::format("{}: the estimation cannot go on: {} {}", end.name,
                             refused ? "" : fmt::format("{} batches brought no result; ", fruitless_),
                             refused || end.state == pilot::TaskState::failed
                                 ? last_words(settings_.dir / file_of(batch.number, "out"))
                                 : "every evaluation of the last one failed: see estimation/evaluations.jsonl"),
                 Exit::task_failed};
  if (end.state == pilot::TaskState::finished) remove_files(batch.number);
  return report_now_and_then();
}

Status Crew::take_results(Batch& batch, double time) {
  std::map<long, Value> lines;
  json::LineReader reader(settings_.dir / file_of(batch.number, "results.jsonl"));
  if (auto read = reader.next())
    for (Value& line : *read)
      if (line.find("trial") != nullptr) lines[line.integer_or("trial", -1)] = std::move(line);
  for (const Trial& trial : batch.trials) {
    const Value line = lines.count(trial.number) > 0 ? lines[trial.number] : Value::object({{"failed", "lost"}});
    const Outcome outcome{line.numbers("residuals"), line.numbers("held_out"), line.numbers("model")};
    const std::string failed = line.text_or("failed", "");
    const double seconds = line.number_or("seconds", 0.0);
    GRANARY_CHECK(log_->trial(version(), trial.number, estimator_->values_of(trial), outcome, failed, seconds, time));
    estimator_->tell(trial.number, failed.empty() ? std::optional(outcome) : std::nullopt);
    seconds_ += seconds;
    if (seconds > 0.0) each_ = each_ > 0.0 ? 0.95 * each_ + 0.05 * seconds : seconds;
  }
  return {};
}

std::optional<estimation::Fitted> Crew::best() const { return begun() ? estimator_->best() : std::nullopt; }

estimation::Estimate Crew::estimate() const { return begun() ? estimator_->estimate() : estimation::Estimate{}; }

Status Crew::report_now_and_then() {
  const long evaluated = estimator_->evaluated();
  const bool often_enough = static_cast<double>(evaluated) < kReportEvery * static_cast<double>(reported_);
  if (often_enough && estimator_->phase() == reported_phase_ && !done()) return {};
  reported_ = evaluated;
  reported_phase_ = estimator_->phase();
  return write_best();
}

Status Crew::write_best() const { return write_quickly(folder_ / "best.json", status()); }

Value Crew::status() const {
  if (!begun()) return Value::object();
  Value status = estimation::to_json(estimate(), estimator_->problem().parameters);
  return status.set("phase", estimation::name_of(estimator_->phase()))
      .set("method", estimation::name_of(settings_.search.method))
      .set("asked", std::int64_t{estimator_->asked()})
      .set("evaluated", std::int64_t{estimator_->evaluated()})
      .set("failed", std::int64_t{estimator_->failed()})
      .set("late", std::int64_t{estimator_->late()})
      .set("seconds", seconds_);
}

}  // namespace granary::estimating
