#include "pilot/task/table.hpp"

#include <fmt/format.h>

namespace granary::pilot {

double Attempt::ran(double now) const {
  double seconds = 0.0;
  for (const Piece& piece : pieces) seconds += (piece.end < 0.0 ? now : piece.end) - piece.start;
  return seconds;
}

std::vector<TaskId> Table::running() const {
  std::vector<TaskId> ids;
  for (int id = running_ids.next(0); id >= 0; id = running_ids.next(id + 1)) ids.push_back(TaskId{id});
  return ids;
}

const Task* Table::find(const std::string& name) const {
  const auto found = by_name.find(name);
  return found == by_name.end() ? nullptr : &at(found->second);
}

namespace {

Error broken(const Task& task, const std::string& what) {
  return {fmt::format("task {} ({}, {}): {}", task.id.value, task.spec.name, name_of(task.state), what),
          Exit::internal};
}

/// What must hold for one task by itself.
Status check_task(const Task& task, const Table& table) {
  const bool active = task.state == TaskState::running || task.state == TaskState::suspended;
  int unmet = 0;
  for (const std::string& name : task.spec.after) {
    const Task* before = table.find(name);
    if (before == nullptr) return broken(task, "comes after an unknown task " + name);
    if (before->id >= task.id) return broken(task, "comes after a later task " + name);
    if (before->state != TaskState::finished) ++unmet;
  }
  if (unmet != task.unmet) return broken(task, fmt::format("{} unmet dependencies, counted {}", unmet, task.unmet));
  if (task.state == TaskState::waiting && unmet == 0) return broken(task, "waits for nothing");
  if ((task.state == TaskState::ready || active) && unmet > 0) return broken(task, "goes before its dependencies");
  if (task.state == TaskState::lost) return broken(task, "a lost task is queued again");
  if (active && task.attempts.empty()) return broken(task, "runs without an attempt");
  if (task.state == TaskState::suspended && !task.spec.fill) return broken(task, "only fillers are suspended");
  if (task.failures > task.spec.retries + 1) return broken(task, "has been tried too often");
  for (std::size_t k = 0; k < task.attempts.size(); ++k) {
    const Attempt& attempt = task.attempts[k];
    const bool last_and_active = active && k + 1 == task.attempts.size();
    if (attempt.number != static_cast<int>(k) + 1) return broken(task, "attempts are not counted 1, 2, 3");
    if (last_and_active != (attempt.outcome == TaskState::running))
      return broken(task, "an attempt's outcome is wrong");
    for (std::size_t p = 0; p < attempt.pieces.size(); ++p) {
      const Piece& piece = attempt.pieces[p];
      const bool open = last_and_active && task.state == TaskState::running && p + 1 == attempt.pieces.size();
      if (open != (piece.end < 0.0)) return broken(task, "a piece is open that should be closed, or closed too early");
      if (!open && piece.end < piece.start) return broken(task, "a piece ends before it starts");
      if (piece.cores.size() != task.spec.cores()) return broken(task, "runs on a wrong number of cores");
    }
  }
  return {};
}

}  // namespace

Status Table::check_invariants() const {
  std::size_t waiting = 0, n_running = 0, n_suspended = 0, ready_count = 0;
  std::set<int> held;
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    const Task& task = tasks[k];
    if (task.id.value != static_cast<int>(k)) return broken(task, "is not where its id says");
    if (by_name.count(task.spec.name) == 0 || by_name.at(task.spec.name) != task.id)
      return broken(task, "is not found by name");
    GRANARY_CHECK(check_task(task, *this));
    const Turn turn{task.spec.priority, task.id};
    waiting += task.state == TaskState::waiting;
    n_running += task.state == TaskState::running;
    n_suspended += task.state == TaskState::suspended;
    ready_count += task.state == TaskState::ready;
    if ((task.state == TaskState::running) != running_ids.has(task.id.value))
      return broken(task, "is not among the running");
    if ((task.state == TaskState::suspended) != (suspended.count(turn) == 1))
      return broken(task, "is not among the suspended");
    if (task.state == TaskState::running) {
      for (const int core : task.last().pieces.back().cores.list()) {
        if (!held.insert(core).second) return broken(task, fmt::format("shares core {} with another task", core));
      }
    }
  }
  if (waiting != n_waiting || n_running != running_ids.size() || n_suspended != suspended.size() ||
      ready_count != n_ready) {
    return Error{"the table's counts do not match its tasks", Exit::internal};
  }
  return {};
}

}  // namespace granary::pilot
