#include "controller/watch/watcher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/json/io.hpp"
#include "controller/run/handover.hpp"
#include "controller/watch/time_left.hpp"
#include "controller/watch/words.hpp"

namespace granary::watch {
namespace fs = std::filesystem;

namespace {

constexpr double kQueuePeriod = 15.0;  // [s]

bool is_true(const json::Value& value) { return value.is_bool() && value.as_bool(); }

}  // namespace

std::string_view name(Phase phase) {
  constexpr std::string_view kNames[] = {"waiting", "running", "stopping", "finishing", "ended"};
  return kNames[static_cast<std::size_t>(phase)];
}

Watcher::Watcher(fs::path dir, Sources sources)
    : dir_(std::move(dir)),
      sources_(std::move(sources)),
      tail_(dir_ / "journal.jsonl"),
      files_(dir_),
      estimation_(dir_) {}

bool Watcher::anything_there() const {
  std::error_code ignored;
  return fs::exists(dir_ / "campaign.json", ignored) || fs::exists(dir_ / "journal.jsonl", ignored);
}

void Watcher::read_campaign() {
  if (!campaign_.is_null()) return;
  if (auto campaign = json::read_file(dir_ / "campaign.json")) campaign_ = std::move(*campaign);
}

void Watcher::ask_status() {
  // A dead campaign tells the same until its journal grows.
  const bool dead = status_.find("alive") != nullptr && !is_true(status_["alive"]) && status_problem_.empty();
  if (dead && status_at_ == history_.n_records() && !history_.pilot_open()) return;
  auto status = sources_.status();
  status_problem_ = status ? "" : status.error().message;
  if (status) status_ = std::move(*status);
  status_at_ = history_.n_records();
}

void Watcher::ask_queue() {
  if (sources_.clock() - queue_asked_ < kQueuePeriod) return;
  queue_asked_ = sources_.clock();
  queue_ = sources_.queue();
}

View Watcher::look() {
  read_campaign();
  // The status first: what the journal says afterwards is at least as new, so an end that the status knows of is told.
  const auto read_journal = [this] {
    tail_.read(
        [this] {
          history_ = {};
          files_ = BurstFiles(dir_);
          estimation_ = EstimationFiles(dir_);
        },
        [this](const pilot::Line& line) { history_.take(line); });
  };
  read_journal();
  ask_status();
  ask_queue();
  read_journal();
  files_.follow(history_.bursts());

  View view;
  const json::Value& understood = campaign_["understood"];
  view.campaign = understood.text_or("name", dir_.filename().string());
  view.description = understood.text_or("description", "");
  view.folder = dir_.string();
  view.coupled = understood.text_or("kind", "tasks") == "coupled";
  view.mode = understood["coupling"].text_or("mode", "");
  view.journal_records = history_.n_records();
  view.time = is_true(status_["alive"]) ? std::max(status_.number_or("time_s", 0.0), history_.last_time())
                                        : history_.last_time();
  fill_tasks(view);
  if (view.coupled) fill_coupling(view);
  if (!understood["estimation"].is_null()) view.fit = estimation_.look(understood["estimation"]);
  fill_phase(view);
  const bool going_on = view.phase == Phase::running;
  if (going_on && view.coupled) {
    view.time_left = time_left_coupled(view, understood["dem"].number_or("longest_burst_s", 0.0), view.time);
  } else if (going_on) {
    std::int64_t ended = 0, all = 0;
    for (const auto& [state, count] : view.counts) {
      all += count;
      if (state == "finished" || state == "failed") ended += count;
    }
    view.time_left = time_left_tasks(ended, all - ended, view.time);
  }
  view.headline = headline(view);
  view.happenings.assign(history_.happenings().begin(), history_.happenings().end());
  view.n_happenings = history_.n_happenings();
  return view;
}

void Watcher::fill_tasks(View& view) const {
  view.nodes = history_.nodes();
  view.cores =
      is_true(status_["alive"]) ? static_cast<int>(status_.integer_or("cores", history_.cores())) : history_.cores();
  view.fillers = history_.fillers();
  view.fillers_done = history_.fillers_done();
  view.core_history = history_.core_history(view.time);
  // A monitor's exit code is its verdict and not a failure, so a coupled campaign's tasks have just ended.
  std::int64_t ended = 0;
  for (const auto& [state, count] : status_["counts"].members_or_none()) {
    if (!count.is_integer()) continue;
    const bool is_end = state == "finished" || state == "failed" || state == "stopped";
    if (view.coupled && is_end)
      ended += count.as_integer();
    else
      view.counts.emplace_back(state, count.as_integer());
  }
  if (ended > 0) view.counts.emplace_back("ended", ended);
  // Over all of the pilot's time, from the journal: the dead pilot's status assumes a machine.
  double busy = 0.0, fillers = 0.0;
  for (const auto& [kind, cores] : view.core_history.busy) {
    for (std::size_t k = 0; k < cores.size(); ++k) {
      const double begin = view.core_history.slice * static_cast<double>(k);
      const double seconds = cores[k] * std::clamp(view.time - begin, 0.0, view.core_history.slice);
      busy += seconds;
      if (kind == "estimation") fillers += seconds;
    }
  }
  if (view.cores > 0 && view.time > 0.0) {
    view.core_use = busy / (view.cores * view.time);
    view.core_use_fillers = fillers / (view.cores * view.time);
  }
  if (!is_true(status_["alive"])) return;
  view.busy_cores = static_cast<int>(status_.integer_or("busy_cores", 0));
  for (const json::Value& task : status_["tasks"].items_or_none()) {
    RunningTask running;
    running.name = task.text_or("name", "?");
    running.kind = run::kind_of_task(running.name, is_true(task["fill"]));
    running.state = task.text_or("state", "");
    running.attempt = static_cast<int>(task.integer_or("attempt", 1));
    for (const double core : task.numbers("cores")) running.cores.push_back(static_cast<int>(core));
    running.seconds = task.number_or("seconds", 0.0);
    if (running.state == "running" && !running.cores.empty()) {
      auto found = std::find_if(view.busy_by_kind.begin(), view.busy_by_kind.end(),
                                [&](const auto& one) { return one.first == running.kind; });
      if (found == view.busy_by_kind.end()) found = view.busy_by_kind.insert(found, {running.kind, 0});
      found->second += static_cast<int>(running.cores.size());
    }
    view.tasks.push_back(std::move(running));
  }
}

void Watcher::fill_coupling(View& view) const {
  const json::Value& understood = campaign_["understood"];
  view.bursts = history_.bursts();
  view.sizes = files_.sizes(view.bursts);
  view.contacts = files_.contacts(view.bursts);
  const double settle = understood["dem_case"].number_or("settle_time", 0.0);
  const double start = understood["pbm_case"].number_or("start_time", 0.0);
  view.process_time = start;
  view.process_end = start + understood.number_or("duration_s", kUnknown);
  for (Burst& burst : view.bursts) {
    if (burst.dem) burst.longest += settle;
    if (!std::isnan(burst.end)) (burst.dem ? view.dem_time : view.process_time) = burst.end;
  }
  view.steadiness = steadiness();
  if (view.bursts.empty() || !std::isnan(view.bursts.back().end)) return;
  if (history_.ended()) return view.bursts.pop_back();  // it was stopped or failed: its result goes nowhere
  view.burst = view.bursts.back();
  view.bursts.pop_back();
  view.burst_time = files_.clock_of(*view.burst);
  if (std::isnan(view.burst_time)) view.burst_time = view.burst->start;
  (view.burst->dem ? view.dem_time : view.process_time) = view.burst_time;
}

std::optional<Steadiness> Watcher::steadiness() const {
  const json::Value& settings = campaign_["understood"]["coupling"];
  if (settings.text_or("mode", "") != "two-way") return std::nullopt;
  const json::Value& numbers = history_.steadiness();
  const json::Value& change = numbers["largest_change"];
  Steadiness steady;
  steady.quiet_time = numbers.number_or("steady_time_s", 0.0);
  steady.window = settings.number_or("steady_window_s", kUnknown);
  steady.rounds = history_.rounds();
  steady.least_rounds = static_cast<int>(settings.integer_or("least_rounds", 0));
  steady.most_rounds = static_cast<int>(settings.integer_or("most_rounds", 0));
  steady.tolerance = settings.number_or("steady_tolerance", kUnknown);
  steady.changed = property_words(change.text_or("what", ""));
  steady.where = change.text_or("where", "");
  steady.change = change.number_or("change", kUnknown);
  steady.noise = change.number_or("noise", 0.0);
  steady.dem_quiet = steady.quiet_time >= steady.window - 1e-9;
  steady.rounds_agree = is_true(numbers["rounds_agree"]);
  return steady;
}

Exit Watcher::exit_of_tasks() const {
  bool failed = false, left = history_.n_records() == 0;
  for (const auto& [state, count] : status_["counts"].members_or_none()) {
    failed |= state == "failed";
    left |= state != "failed" && state != "finished" && state != "stopped";
  }
  return left || history_.stopped_resumably() ? Exit::stopped : failed ? Exit::task_failed : Exit::ok;
}

void Watcher::fill_phase(View& view) const {
  // How a coupled campaign ended stands in its journal, whatever else could not be found out.
  if (!status_problem_.empty() && !(view.coupled && history_.ended())) view.warnings.push_back(status_problem_);
  if (const std::string failure = status_.text_or("failure", ""); !failure.empty()) view.warnings.push_back(failure);
  for (const std::string& problem : files_.problems()) view.warnings.push_back(problem);
  if (tail_.damaged() > 0)
    view.warnings.push_back(fmt::format("{}: {} of wrong checksum", (dir_ / "journal.jsonl").string(),
                                        plural(static_cast<long>(tail_.damaged()), "line", "lines")));
  const bool over = history_.ended() && *history_.ended() != "stopped";
  if (is_true(status_["alive"])) {
    const bool stopping = is_true(status_["stopping"]) || history_.stop_asked();
    view.phase = history_.ended() ? Phase::finishing : stopping ? Phase::stopping : Phase::running;
    return;
  }
  if (!tail_.exists() || (queue_.size() > 0 && !over)) return;  // waiting
  view.phase = Phase::ended;
  if (!view.coupled) {
    view.exit = exit_of_tasks();
  } else if (history_.ended()) {
    view.exit = *history_.ended() == "failed" ? Exit::task_failed : over ? Exit::ok : Exit::stopped;
  } else {
    view.exit = Exit::stopped;
  }
  if (history_.pilot_open()) view.warnings.push_back("The pilot was killed: it did not say that it ended.");
}

std::string Watcher::headline(const View& view) const {
  switch (view.phase) {
    case Phase::waiting: {
      for (const json::Value& job : queue_.items_or_none())
        return fmt::format("Job {} waits in Slurm's queue: {} ({})", job.text_or("job", "?"), job.text_or("state", ""),
                           job.text_or("reason", ""));
      return "No pilot has begun yet";
    }
    case Phase::ended:
      if (history_.ended()) return fmt::format("Ended {}: {}", *history_.ended(), history_.ended_message());
      if (view.exit == Exit::stopped)
        return fmt::format("{}; go on with: granary resume {}",
                           history_.pilot_open() ? "The pilot was killed" : "Stopped", view.folder);
      return view.exit == Exit::ok ? "All tasks finished" : "A task failed for good";
    case Phase::finishing:
      return fmt::format("Ended {}; results and report are being written", history_.ended().value_or(""));
    case Phase::stopping:
      return "Stopping: " + what_runs(view);
    case Phase::running:
      return what_runs(view);
  }
  return "";
}

std::string Watcher::what_runs(const View& view) const {
  if (view.burst && !std::isnan(view.burst->pilot_end))
    return fmt::format("{} is over; its result goes to the other side", burst_words(view.burst->folder));
  if (view.burst)
    return fmt::format("{} runs{}", burst_words(view.burst->folder),
                       view.burst->attempt > 1 ? fmt::format(", attempt {}", view.burst->attempt) : "");
  if (view.coupled) return "Between two bursts";
  std::int64_t ended = 0, all = 0;
  for (const auto& [state, count] : view.counts) {
    all += count;
    if (state == "finished" || state == "failed") ended += count;
  }
  return fmt::format("{} of {} tasks ended", ended, all);
}

}  // namespace granary::watch
