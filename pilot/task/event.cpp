#include "pilot/task/event.hpp"

#include <fmt/format.h>

#include "common/json/text.hpp"
#include "pilot/task/past.hpp"
#include "pilot/task/spec_json.hpp"

namespace granary::pilot {
namespace {

Result<CoreSet> cores_in(const json::Value& payload) { return CoreSet::parse(payload.text_or("cores", "")); }

/// Writes what an event is about into the object that has its time already.
struct Payload {
  json::TextObject& out;

  json::TextObject& of(TaskId id) const { return out.set("id", id.value); }
  json::TextObject& of(AttemptId attempt) const { return of(attempt.task).set("attempt", attempt.number); }

  void operator()(const Submitted& e) const { append(of(e.id).member("task"), e.spec); }
  void operator()(const Placed& e) const { of(e.attempt).set("cores", e.cores.text()); }
  void operator()(const Started& e) const {
    of(e.attempt).set("pid", e.pid).set("start_ticks", static_cast<std::int64_t>(e.start_ticks));
  }
  void operator()(const StartFailed& e) const { of(e.attempt).set("reason", e.reason); }
  void operator()(const Exited& e) const {
    of(e.attempt).set("exit_code", e.exit_code).set("signal", e.signal).set("cpu_s", e.cpu_s);
    if (!e.missing.empty()) out.set("missing", std::vector<std::string>(e.missing.begin(), e.missing.end()));
  }
  void operator()(const StopAsked& e) const { of(e.id).set("reason", e.reason).set("resumable", e.resumable); }
  void operator()(const TimedOut& e) const { of(e.attempt); }
  void operator()(const GraceOver& e) const { of(e.attempt); }
  void operator()(const Suspended& e) const { of(e.attempt); }
  void operator()(const Resumed& e) const { of(e.attempt).set("cores", e.cores.text()); }
  void operator()(const Preempted& e) const { of(e.attempt); }
  void operator()(const Lost& e) const { of(e.attempt).set("reason", e.reason); }
  void operator()(const Abandoned& e) const { of(e.attempt).set("reason", e.reason); }
  void operator()(const Restored& e) const {
    const json::Value past = past_to_json(e.task);
    for (const auto& [key, value] : past.members()) out.set(key, value);
  }
  void operator()(const Reopened& e) const { of(e.id); }
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

std::string_view kind_of(const Event& event) { return std::visit(KindOf{}, event.what); }

void append(std::string& text, const Event& event) {
  json::TextObject out(text);
  out.set("time_s", event.time);
  std::visit(Payload{out}, event.what);
}

Result<Event> event_from_json(std::string_view kind, const json::Value& payload) {
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
