#include "pilot/task/event.hpp"

#include <fmt/format.h>

#include "pilot/task/past.hpp"
#include "pilot/task/spec_json.hpp"

namespace granary::pilot {
namespace {

Result<CoreSet> cores_in(const json::Value& payload) { return CoreSet::parse(payload.text_or("cores", "")); }

json::Value of_attempt(double time, AttemptId attempt) {
  return json::Value::object({{"time_s", time}, {"id", attempt.task.value}, {"attempt", attempt.number}});
}

struct ToJson {
  double time;
  json::Value operator()(const Submitted& e) const {
    return json::Value::object({{"time_s", time}, {"id", e.id.value}, {"task", to_json(e.spec)}});
  }
  json::Value operator()(const Placed& e) const { return of_attempt(time, e.attempt).set("cores", e.cores.text()); }
  json::Value operator()(const Started& e) const {
    return of_attempt(time, e.attempt).set("pid", e.pid).set("start_ticks", static_cast<std::int64_t>(e.start_ticks));
  }
  json::Value operator()(const StartFailed& e) const { return of_attempt(time, e.attempt).set("reason", e.reason); }
  json::Value operator()(const Exited& e) const {
    json::Value value = of_attempt(time, e.attempt);
    value.set("exit_code", e.exit_code).set("signal", e.signal).set("cpu_s", e.cpu_s);
    for (const auto& file : e.missing) {
      if (value.find("missing") == nullptr) value.set("missing", json::Value::array());
      value.find("missing")->push(file.string());
    }
    return value;
  }
  json::Value operator()(const StopAsked& e) const {
    return json::Value::object(
        {{"time_s", time}, {"id", e.id.value}, {"reason", e.reason}, {"resumable", e.resumable}});
  }
  json::Value operator()(const TimedOut& e) const { return of_attempt(time, e.attempt); }
  json::Value operator()(const GraceOver& e) const { return of_attempt(time, e.attempt); }
  json::Value operator()(const Suspended& e) const { return of_attempt(time, e.attempt); }
  json::Value operator()(const Resumed& e) const { return of_attempt(time, e.attempt).set("cores", e.cores.text()); }
  json::Value operator()(const Preempted& e) const { return of_attempt(time, e.attempt); }
  json::Value operator()(const Lost& e) const { return of_attempt(time, e.attempt).set("reason", e.reason); }
  json::Value operator()(const Abandoned& e) const { return of_attempt(time, e.attempt).set("reason", e.reason); }
  json::Value operator()(const Restored& e) const { return past_to_json(e.task).set("time_s", time); }
  json::Value operator()(const Reopened& e) const {
    return json::Value::object({{"time_s", time}, {"id", e.id.value}});
  }
};

struct KindOf {
  const char* operator()(const Submitted&) const { return "task.submit"; }
  const char* operator()(const Placed&) const { return "task.place"; }
  const char* operator()(const Started&) const { return "task.start"; }
  const char* operator()(const StartFailed&) const { return "task.start_failed"; }
  const char* operator()(const Exited&) const { return "task.exit"; }
  const char* operator()(const StopAsked&) const { return "task.stop"; }
  const char* operator()(const TimedOut&) const { return "task.timeout"; }
  const char* operator()(const GraceOver&) const { return "task.grace_over"; }
  const char* operator()(const Suspended&) const { return "task.suspend"; }
  const char* operator()(const Resumed&) const { return "task.resume"; }
  const char* operator()(const Preempted&) const { return "task.preempt"; }
  const char* operator()(const Lost&) const { return "task.lost"; }
  const char* operator()(const Abandoned&) const { return "task.abandon"; }
  const char* operator()(const Restored&) const { return "task.past"; }
  const char* operator()(const Reopened&) const { return "task.reopen"; }
};

Exited exited(AttemptId attempt, const json::Value& payload) {
  Exited event{attempt,
               static_cast<int>(payload.integer_or("exit_code", -1)),
               static_cast<int>(payload.integer_or("signal", 0)),
               payload.number_or("cpu_s", 0.0),
               {}};
  if (const json::Value* missing = payload.find("missing"); missing != nullptr && missing->is_array()) {
    for (const json::Value& file : missing->items()) {
      if (file.is_string()) event.missing.emplace_back(file.as_string());
    }
  }
  return event;
}

}  // namespace

std::string kind_of(const Event& event) { return std::visit(KindOf{}, event.what); }

json::Value to_json(const Event& event) { return std::visit(ToJson{event.time}, event.what); }

Result<Event> event_from_json(const std::string& kind, const json::Value& payload) {
  const TaskId id{static_cast<int>(payload.integer_or("id", -1))};
  const AttemptId attempt{id, static_cast<int>(payload.integer_or("attempt", 0))};
  const double time = payload.number_or("time_s", 0.0);
  const auto reason = [&] { return payload.text_or("reason", ""); };
  if (id.value < 0) return Error{fmt::format("a record of kind {} names no task", kind)};
  if (kind == "task.submit") return Event{time, Submitted{id, spec_from_json(payload["task"])}};
  if (kind == "task.past") {
    GRANARY_TRY(Task task, past_from_json(payload));
    return Event{time, Restored{std::move(task)}};
  }
  if (kind == "task.place") {
    GRANARY_TRY(CoreSet cores, cores_in(payload));
    return Event{time, Placed{attempt, std::move(cores)}};
  }
  if (kind == "task.start") {
    return Event{time, Started{attempt, static_cast<int>(payload.integer_or("pid", 0)),
                               static_cast<std::uint64_t>(payload.integer_or("start_ticks", 0))}};
  }
  if (kind == "task.start_failed") return Event{time, StartFailed{attempt, reason()}};
  if (kind == "task.exit") return Event{time, exited(attempt, payload)};
  if (kind == "task.stop") {
    const json::Value& resumable = payload["resumable"];
    return Event{time, StopAsked{id, reason(), resumable.is_bool() && resumable.as_bool()}};
  }
  if (kind == "task.timeout") return Event{time, TimedOut{attempt}};
  if (kind == "task.grace_over") return Event{time, GraceOver{attempt}};
  if (kind == "task.suspend") return Event{time, Suspended{attempt}};
  if (kind == "task.resume") {
    GRANARY_TRY(CoreSet cores, cores_in(payload));
    return Event{time, Resumed{attempt, std::move(cores)}};
  }
  if (kind == "task.preempt") return Event{time, Preempted{attempt}};
  if (kind == "task.lost") return Event{time, Lost{attempt, reason()}};
  if (kind == "task.abandon") return Event{time, Abandoned{attempt, reason()}};
  if (kind == "task.reopen") return Event{time, Reopened{id}};
  return Error{fmt::format("unknown kind of record \"{}\"", kind)};
}

}  // namespace granary::pilot
