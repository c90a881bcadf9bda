#include "controller/watch/history.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "common/json/text.hpp"
#include "controller/run/handover.hpp"
#include "controller/watch/words.hpp"
#include "pilot/task/core_set.hpp"

namespace granary::watch {

namespace {

constexpr std::size_t kMostHappenings = 200;

std::string capital(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

/// How many cores a record names: "0-3,8", or a list in journals of before.
int n_cores_in(const json::Value& cores) {
  if (!cores.is_string()) return static_cast<int>(cores.items_or_none().size());
  const auto set = pilot::CoreSet::parse(cores.as_string());
  return set ? set->size() : 0;
}

std::string burst_of_event(const json::Value& event) {
  return fmt::format("{:04}-{}", event.integer_or("round", 0), event.text_or("kind", ""));
}

}  // namespace

void History::take(const pilot::Line& line) {
  ++n_records_;
  const bool of_interest = line.kind.starts_with("task.") || line.kind.starts_with("pilot.") ||
                           line.kind.starts_with("node.") || line.kind.starts_with("coupling.") ||
                           line.kind.starts_with("estimation.");
  const auto payload = of_interest ? json::parse_text(line.payload) : std::nullopt;
  if (!payload) return;
  if (line.kind == "pilot.open") pilot_opened(*payload, line.wall_time);
  // The coupling's records carry no pilot time; the wall clock since the pilot began says it.
  const double by_wall = base_time_ + line.wall_time - base_wall_;
  const bool of_coupling = line.kind.starts_with("coupling.");  // whose times are those of the bursts' own clocks
  last_time_ = std::max(last_time_, of_coupling ? kUnknown : payload->number_or("time_s", kUnknown));
  if (of_coupling && by_wall > last_time_) last_time_ = by_wall;

  if (line.kind == "pilot.close") {
    pilot_open_ = false;
    say(Level::minor, "The pilot ends");
  } else if (line.kind == "node.lost") {
    say(Level::warning,
        fmt::format("Node {} is lost: {}", payload->text_or("name", "?"), payload->text_or("reason", "")));
  } else if (line.kind == "node.back") {
    say(Level::usual, fmt::format("Node {} is back", payload->text_or("name", "?")));
  } else if (line.kind == "coupling.event") {
    coupling_event(*payload);
  } else if (line.kind == "coupling.decision") {
    decision(*payload);
  } else if (line.kind == "estimation.adopted") {
    say(Level::usual, fmt::format("{} takes the best parameters known", burst_words(payload->text_or("burst", "?"))));
  } else if (line.kind == "estimation.final") {
    say(Level::usual, "The final run begins, with the parameters as estimated");
  } else if (line.kind.starts_with("task.")) {
    of_task(line.kind.substr(5), *payload);
  }
}

void History::say(Level level, std::string words) {
  happenings_.push_back({last_time_, level, std::move(words)});
  ++n_happenings_;
  if (happenings_.size() > kMostHappenings) happenings_.pop_front();
}

void History::pilot_opened(const json::Value& payload, double wall_time) {
  const bool again = base_wall_ == base_wall_;
  const bool died = again && pilot_open_;
  base_time_ = last_time_ = std::max(last_time_, payload.number_or("time_s", 0.0));
  base_wall_ = wall_time;
  pilot_open_ = true;
  stopped_resumably_ = stop_asked_ = false;
  nodes_ = cores_ = 0;
  for (const json::Value& node : payload["nodes"].items_or_none()) {
    ++nodes_;
    cores_ += static_cast<int>(node.integer_or("cores", 0));
  }
  const std::string where =
      nodes_ > 1 ? fmt::format("{} cores of {} nodes", cores_, nodes_) : plural(cores_, "core", "cores");
  if (died) say(Level::warning, "The pilot had been killed; what ran then is queued again");
  say(Level::usual, fmt::format("The pilot {} on {}", again ? "goes on" : "starts", where));
}

// --- tasks ---

void History::of_task(std::string_view what, const json::Value& payload) {
  const std::int64_t id = payload.integer_or("id", -1);
  if (what == "submit") {
    const json::Value& spec = payload["task"];
    const json::Value& fill = spec["fill"];
    Task task;
    task.name = spec.text_or("name", "?");
    task.kind = run::kind_of_task(task.name, fill.is_bool() && fill.as_bool());
    fillers_ += task.kind == "estimation";
    tasks_.insert_or_assign(id, std::move(task));
    return;
  }
  if (what == "past") return past_task(payload);
  const auto found = tasks_.find(id);
  if (found == tasks_.end()) return;
  Task& task = found->second;
  if (what == "place" || what == "resume") {
    task.cores = n_cores_in(payload["cores"]);
    task.since = last_time_;
  } else if (what == "suspend" || what == "preempt") {
    leave_cores(task);
  } else if (what == "stop") {
    task.stop_asked = true;
    const json::Value& resumable = payload["resumable"];
    stopped_resumably_ |= resumable.is_bool() && resumable.as_bool();
  } else if (what == "reopen") {
    task.stop_asked = false;
  } else if (what == "timeout") {
    say(Level::warning, fmt::format("{} ran out of time and is ended", task.name));
  } else if (what == "lost") {
    leave_cores(task);
    say(Level::warning, fmt::format("{} was lost and is queued again: {}", task.name, payload.text_or("reason", "")));
  } else if (what == "start_failed") {
    leave_cores(task);
    say(Level::warning, fmt::format("{} could not be started: {}", task.name, payload.text_or("reason", "")));
  } else if (what == "exit") {
    task_exited(task, payload);
  }
}

/// A task that ended before the journal was compacted: what is left of it are its stretches of time on cores.
void History::past_task(const json::Value& payload) {
  const json::Value& fill = payload["task"]["fill"];
  const std::string kind = run::kind_of_task(payload["task"].text_or("name", "?"), fill.is_bool() && fill.as_bool());
  fillers_ += kind == "estimation";
  fillers_done_ += kind == "estimation" && payload.text_or("state", "") == "finished";
  for (const json::Value& attempt : payload["attempts"].items_or_none()) {
    for (const json::Value& piece : attempt["pieces"].items_or_none()) {
      const json::Array& parts = piece.items_or_none();
      if (parts.size() < 3 || !parts[0].is_number() || !parts[1].is_number()) continue;
      core_seconds_.add(kind, parts[0].as_number(), parts[1].as_number(), n_cores_in(parts[2]));
    }
  }
}

void History::leave_cores(Task& task) {
  core_seconds_.add(task.kind, task.since, last_time_, task.cores);
  task.since = kUnknown;
}

void History::task_exited(Task& task, const json::Value& payload) {
  const double ran = last_time_ - task.since;
  leave_cores(task);
  const std::int64_t code = payload.integer_or("exit_code", 0);
  const std::int64_t signal = payload.integer_or("signal", 0);
  const std::size_t missing = payload["missing"].items_or_none().size();
  fillers_done_ += task.kind == "estimation" && code == 0;
  if (task.stop_asked || task.kind == "monitor") return;  // its exit code is its verdict
  if (code == 0 && missing == 0)
    return say(Level::minor, fmt::format("{} finished after {}", task.name, duration(ran)));
  if (code == 0)
    say(Level::warning,
        fmt::format("{} failed: {} it promised missing", task.name,
                    plural(static_cast<long>(missing), "file", "files") + (missing == 1 ? " is" : " are")));
  else if (signal != 0)
    say(Level::warning, fmt::format("{} was ended by signal {}", task.name, signal));
  else
    say(Level::warning, fmt::format("{} failed with exit code {}", task.name, code));
}

CoreHistory History::core_history(double now) const {
  CoreSeconds seconds = core_seconds_;
  for (const auto& [id, task] : tasks_) seconds.add(task.kind, task.since, now, task.cores);
  return seconds.history(now);
}

// --- coupling ---

Burst* History::find(const std::string& folder) {
  const auto found = std::find_if(bursts_.rbegin(), bursts_.rend(), [&](const Burst& b) { return b.folder == folder; });
  return found == bursts_.rend() ? nullptr : &*found;
}

void History::coupling_event(const json::Value& event) {
  const std::string type = event.text_or("event", "");
  const std::string folder = burst_of_event(event);
  const json::Value& summary = event["summary"];
  if (type == "stop_asked") {
    stop_asked_ = true;
    say(Level::usual, "Stopping: " + event.text_or("message", "asked to"));
  } else if (type == "resumed") {
    ended_.reset();
    stop_asked_ = false;
  } else if (type == "task_ended") {
    if (Burst* burst = find(folder)) burst->pilot_end = last_time_;
  } else if (type == "monitor_spoke") {
    const json::Value& verdict = event["verdict"];
    const std::string said = verdict.text_or("verdict", "");
    if (said == "ended") return;
    say(said == "diverged" ? Level::warning : Level::usual,
        fmt::format("{} {}: {}", burst_words(folder), said == "converged" ? "has good numbers" : said,
                    verdict.text_or("message", "")));
  } else if (type == "monitor_failed" || type == "exchange_failed") {
    say(Level::warning, fmt::format("{}: {}", burst_words(folder), event.text_or("message", "")));
  } else if (type == "dem_exchanged") {
    Burst* burst = find(folder);
    if (burst == nullptr) return;
    burst->particles = summary.number_or("particles", kUnknown);
    burst->collision_rate = summary.number_or("collision_frequency_1_s", kUnknown);
    burst->impact_rate = summary.number_or("impact_frequency_1_s", kUnknown);
    say(Level::usual, fmt::format("{} gives {:.3g} collisions and {:.3g} impacts per particle and second",
                                  burst_words(folder), burst->collision_rate, burst->impact_rate));
  } else if (type == "pbm_exchanged") {
    ++rounds_;
    Burst* burst = find(folder);
    const auto d50 = summary.numbers("d50_m"), number = summary.numbers("number");
    if (burst == nullptr || d50.empty()) return;
    burst->particles = std::accumulate(number.begin(), number.end(), 0.0);
    burst->d50_smallest = *std::min_element(d50.begin(), d50.end());
    burst->d50_largest = *std::max_element(d50.begin(), d50.end());
    say(Level::usual, fmt::format("{} gives d50 {:.3g} to {:.3g} um", burst_words(folder), 1e6 * burst->d50_smallest,
                                  1e6 * burst->d50_largest));
  }
}

void History::decision(const json::Value& decision) {
  const std::string action = decision.text_or("action", "");
  const json::Value& why = decision["why"];
  const std::string message = why.text_or("message", "");
  // Only these name the rounds and the window: a monitor's verdict has numbers of another kind.
  if (why["numbers"].find("steady_time_s") != nullptr) {
    // What was compared after the last whole round still holds while the next one runs.
    for (const auto& [key, value] : why["numbers"].members_or_none()) steadiness_.set(key, value);
  }
  if (action == "end") {
    ended_ = decision.text_or("how", "failed");
    ended_message_ = message;
    return say(*ended_ == "failed" ? Level::warning : Level::usual,
               fmt::format("The campaign ends {}: {}", *ended_, message));
  }
  ended_.reset();
  if (action == "start_burst") return burst_started(decision);
  if (action != "exchange") return;
  if (Burst* burst = find(decision.text_or("burst", ""))) {
    burst->end = decision.number_or("time_s", kUnknown);
    burst->reason = why.text_or("reason", "");
    burst->message = message;
    const std::string words = burst_words(burst->folder);
    if (burst->reason == "longest" || burst->reason == "end")
      say(Level::usual,
          message.starts_with(burst->folder) ? words + message.substr(burst->folder.size()) : capital(message));
  }
}

void History::burst_started(const json::Value& decision) {
  Burst burst;
  burst.folder = decision.text_or("burst", "");
  burst.dem = burst.folder.ends_with("-dem");
  burst.round = std::atoi(burst.folder.c_str());
  burst.attempt = static_cast<int>(decision.integer_or("attempt", 1));
  burst.start = decision.number_or("start_time_s", 0.0);
  burst.longest = decision.number_or("longest_s", 0.0);
  burst.pilot_start = last_time_;
  burst.why_started = decision["why"].text_or("message", "");
  // Another attempt of the same burst takes the place of the one before.
  if (!bursts_.empty() && bursts_.back().folder == burst.folder) bursts_.pop_back();
  say(Level::usual,
      fmt::format("{} starts at {:.4g} s of {} time{}", burst_words(burst.folder), burst.start,
                  burst.dem ? "DEM" : "process", burst.attempt > 1 ? fmt::format(", attempt {}", burst.attempt) : ""));
  bursts_.push_back(std::move(burst));
}

}  // namespace granary::watch
