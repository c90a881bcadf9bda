#include "pilot/pilot.hpp"

#include <fmt/format.h>

#include "common/json/problems.hpp"
#include "pilot/pilot_state.hpp"
#include "pilot/schedule/check_tasks.hpp"
#include "pilot/schedule/explain.hpp"
#include "pilot/task/spec_json.hpp"

namespace granary::pilot {

namespace fs = std::filesystem;

Pilot::Pilot(std::unique_ptr<State> state) : state_(std::move(state)) {}

Pilot::~Pilot() {
  if (state_) (void)state_->journal.append("pilot.close", json::Value::object({{"time_s", now()}}));
}

Result<std::unique_ptr<Pilot>> Pilot::open(PilotOptions options, EventLoop& loop, Launcher& launcher,
                                           Journal& journal) {
  std::error_code error;
  options.dir = fs::absolute(options.dir, error).lexically_normal();
  std::unique_ptr<Pilot> pilot(new Pilot(std::make_unique<State>(std::move(options), loop, launcher, journal)));
  GRANARY_CHECK(pilot->state_->replay());
  GRANARY_CHECK(pilot->state_->begin());
  return pilot;
}

Result<TaskId> Pilot::submit(TaskSpec spec) {
  State& state = *state_;
  if (const Task* known = state.table.find(spec.name)) {
    if (known->spec != spec) {
      return Error{fmt::format(
          "task \"{}\" is in the journal with other settings; use another name, or another folder (--dir)", spec.name)};
    }
    if (has_ended(known->state)) state.act(Report{known->id});
    return known->id;
  }
  if (spec.name.empty() || spec.command.empty() || spec.command[0].empty()) {
    return Error{fmt::format("task \"{}\" has no {}", spec.name, spec.name.empty() ? "name" : "command")};
  }
  for (const std::string& before : spec.after) {
    if (state.table.find(before) != nullptr) continue;
    return Error{fmt::format("task \"{}\" comes after \"{}\", which has not been submitted", spec.name, before)};
  }
  if (const Status fits = check_fits(spec, state.scheduler.layouts()); !fits) {
    return Error{fmt::format("task \"{}\" {}", spec.name, fits.error().message)};
  }
  const TaskId id{static_cast<int>(state.table.tasks.size())};
  state.count_folder(spec);
  state.idle_told = false;
  state.happens({now(), Submitted{id, std::move(spec)}});
  return id;
}

void Pilot::lose_node(int node, const std::string& reason) { state_->lose_node(node, reason); }
void Pilot::regain_node(int node) { state_->regain_node(node); }

void Pilot::deadline(double wall_time) {
  state_->deadline = now() + wall_time - state_->loop.wall_time();
  state_->turn_soon();
}

void Pilot::stop(TaskId id, const std::string& reason) {
  if (state_->table.has(id) && !has_ended(state(id))) state_->happens({now(), StopAsked{id, reason, false}});
}

void Pilot::stop_all(const std::string& reason) {
  if (state_->stopping) return;
  state_->stopping = true;
  state_->stop_reason = reason;
  state_->stop_active();
}

bool Pilot::stopping() const { return state_->stopping; }
void Pilot::on_end(std::function<void(const TaskEnd&)> callback) {
  state_->end_callbacks.push_back(std::move(callback));
}
void Pilot::on_idle(std::function<void()> callback) { state_->idle_callbacks.push_back(std::move(callback)); }
bool Pilot::idle() const { return state_->idle(); }
const std::optional<Error>& Pilot::failure() const { return state_->failure; }

std::optional<TaskId> Pilot::find(const std::string& name) const {
  const Task* task = state_->table.find(name);
  return task == nullptr ? std::nullopt : std::optional(task->id);
}

TaskState Pilot::state(TaskId id) const { return state_->table.at(id).state; }
const TaskSpec& Pilot::spec(TaskId id) const { return state_->table.at(id).spec; }

std::optional<TaskEnd> Pilot::end(TaskId id) const {
  const Task& task = state_->table.at(id);
  if (!has_ended(task.state)) return std::nullopt;
  return end_of(task, state_->folder_of(task.spec));
}

std::vector<TaskEnd> Pilot::ends() const {
  std::vector<TaskEnd> ends;
  for (const Task& task : state_->table.tasks) {
    if (has_ended(task.state)) ends.push_back(end_of(task, state_->folder_of(task.spec)));
  }
  return ends;
}

double Pilot::now() const { return state_->now(); }
const Machine& Pilot::machine() const { return state_->options.machine; }
Usage Pilot::usage() const { return usage_of(state_->table, machine().n_cores(), now()); }
std::vector<Interval> Pilot::timeline() const { return timeline_of(state_->table, now()); }

json::Value Pilot::status() const {
  json::Value status = status_of(state_->table, state_->scheduler.resources(), now());
  status.set("stopping", state_->stopping);
  if (state_->failure) status.set("failure", state_->failure->message);
  return status;
}

Result<std::string> Pilot::explain(const std::string& name) const {
  if (const Task* task = state_->table.find(name)) {
    return granary::pilot::explain(*task, state_->table, state_->scheduler, now(), state_->stopping);
  }
  std::vector<std::string> names;
  for (const Task& task : state_->table.tasks) names.push_back(task.spec.name);
  const std::string near = json::did_you_mean(name, names);
  return Error{
      fmt::format("no task is called \"{}\".{}", name, near.empty() ? "" : fmt::format(" Did you mean \"{}\"?", near))};
}

json::Value Pilot::answer_submit(const json::Value& task) {
  json::Problems problems;
  const std::string called = task.text_or("name", "");
  json::Reader reader(task, called.empty() ? "request" : fmt::format("task \"{}\"", called), problems);
  TaskSpec spec = read_task(reader);
  if (!problems.empty()) return json::Value::object({{"error", problems.error().message}});
  if (stopping()) return json::Value::object({{"error", "the pilot is stopping; it takes no tasks any more"}});
  const std::string name = spec.name;
  const auto id = submit(std::move(spec));
  // Whoever asked is told once it cannot be lost any more.
  if (const Status written = state_->flush(); !written)
    return json::Value::object({{"error", written.error().message}});
  if (!id) return json::Value::object({{"error", id.error().message}});
  return json::Value::object({{"submitted", name}, {"id", id->value}});
}

json::Value Pilot::answer(const json::Value& request) {
  const auto refuse = [](const std::string& why) { return json::Value::object({{"error", why}}); };
  const std::string ask = request.text_or("ask", ""), name = request.text_or("task", "");
  if (ask == "submit") return answer_submit(request["task"]);
  if (ask == "status") return status();
  if (ask == "explain") {
    const auto text = explain(name);
    return text ? json::Value::object({{"text", *text}}) : refuse(text.error().message);
  }
  if (ask != "stop") return refuse(fmt::format("cannot \"{}\"; known are status, stop, explain, submit", ask));
  const std::string reason = request.text_or("reason", "asked to stop");
  if (name.empty()) {
    stop_all(reason);
  } else if (const auto id = find(name)) {
    stop(*id, reason);
  } else {
    return refuse(explain(name).error().message);
  }
  return json::Value::object({{"stopping", name.empty() ? "all" : name}});
}

}  // namespace granary::pilot
