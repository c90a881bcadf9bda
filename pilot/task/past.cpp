#include "pilot/task/past.hpp"

#include <fmt/format.h>

#include <array>

#include "pilot/task/spec_json.hpp"

namespace granary::pilot {
namespace {

constexpr std::array kStates{TaskState::waiting,  TaskState::ready,  TaskState::running, TaskState::suspended,
                             TaskState::finished, TaskState::failed, TaskState::stopped, TaskState::lost};

Result<TaskState> state_in(const json::Value& value, std::string_view key) {
  const std::string name = value.text_or(key, "");
  for (const TaskState state : kStates) {
    if (name_of(state) == name) return state;
  }
  return Error{fmt::format("\"{}\" is no state of a task", name)};
}

json::Value attempt_to_json(const Attempt& attempt) {
  json::Value pieces = json::Value::array();
  for (const Piece& piece : attempt.pieces)
    pieces.push(json::Array{json::Value(piece.start), json::Value(piece.end), json::Value(piece.cores.text())});
  json::Value value = json::Value::object({{"outcome", name_of(attempt.outcome)}, {"pieces", std::move(pieces)}});
  // The usual: began and ended with its only piece, exit code 0.
  if (attempt.start != attempt.pieces.front().start) value.set("start_s", attempt.start);
  if (attempt.end != attempt.pieces.back().end) value.set("end_s", attempt.end);
  if (attempt.exit_code != 0) value.set("exit_code", attempt.exit_code);
  if (attempt.signal != 0) value.set("signal", attempt.signal);
  if (attempt.cpu_s != 0.0) value.set("cpu_s", attempt.cpu_s);
  if (!attempt.reason.empty()) value.set("reason", attempt.reason);
  return value;
}

Result<Attempt> attempt_from_json(const json::Value& value, int number) {
  Attempt attempt;
  attempt.number = number;
  for (const json::Value& piece : value["pieces"].items_or_none()) {
    const json::Array& items = piece.items_or_none();
    if (items.size() != 3 || !items[0].is_number() || !items[1].is_number() || !items[2].is_string())
      return Error{"a piece of an attempt is not [start, end, cores]"};
    GRANARY_TRY(CoreSet cores, CoreSet::parse(items[2].as_string()));
    attempt.pieces.push_back({items[0].as_number(), items[1].as_number(), std::move(cores)});
  }
  if (attempt.pieces.empty()) return Error{"an attempt has no pieces"};
  GRANARY_TRY(attempt.outcome, state_in(value, "outcome"));
  attempt.start = value.number_or("start_s", attempt.pieces.front().start);
  attempt.end = value.number_or("end_s", attempt.pieces.back().end);
  attempt.exit_code = static_cast<int>(value.integer_or("exit_code", 0));
  attempt.signal = static_cast<int>(value.integer_or("signal", 0));
  attempt.cpu_s = value.number_or("cpu_s", 0.0);
  attempt.reason = value.text_or("reason", "");
  return attempt;
}

}  // namespace

json::Value past_to_json(const Task& task) {
  json::Value attempts = json::Value::array();
  for (const Attempt& attempt : task.attempts) attempts.push(attempt_to_json(attempt));
  json::Value value = json::Value::object({{"id", task.id.value},
                                           {"state", name_of(task.state)},
                                           {"task", to_json(task.spec)},
                                           {"attempts", std::move(attempts)}});
  if (task.failures != 0) value.set("failures", task.failures);
  if (!task.reason.empty()) value.set("reason", task.reason);
  if (task.resumable) value.set("resumable", true);
  if (task.ended != 0.0) value.set("ended_s", task.ended);
  return value;
}

Result<Task> past_from_json(const json::Value& value) {
  Task task;
  task.id = TaskId{static_cast<int>(value.integer_or("id", -1))};
  task.spec = spec_from_json(value["task"]);
  GRANARY_TRY(task.state, state_in(value, "state"));
  const bool runs = task.state == TaskState::running || task.state == TaskState::suspended;
  if (runs || task.state == TaskState::lost)
    return Error{"a task of the past cannot be " + std::string(name_of(task.state))};
  for (const json::Value& attempt : value["attempts"].items_or_none()) {
    GRANARY_TRY(Attempt read, attempt_from_json(attempt, static_cast<int>(task.attempts.size()) + 1));
    task.attempts.push_back(std::move(read));
  }
  task.failures = static_cast<int>(value.integer_or("failures", 0));
  task.reason = value.text_or("reason", "");
  task.resumable = value["resumable"].is_bool() && value["resumable"].as_bool();
  task.ended = value.number_or("ended_s", 0.0);
  return task;
}

}  // namespace granary::pilot
