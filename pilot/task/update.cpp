#include "pilot/task/update.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstring>

namespace granary::pilot {
namespace {

/// One event's worth of changes.
class Step {
 public:
  Step(Table& table, double time, std::vector<Action>& actions) : table_(table), time_(time), actions_(actions) {}

  void operator()(Submitted&& event) {
    if (!table_.by_name.try_emplace(event.spec.name, event.id).second) return;
    Task& added = table_.tasks.emplace_back();
    added.id = event.id;
    added.spec = std::move(event.spec);
    count_dependencies(added);
    ++table_.n_waiting;
    const auto fails = [this](const std::string& name) { return never_finishes(*table_.find(name)); };
    const auto hopeless = std::find_if(added.spec.after.begin(), added.spec.after.end(), fails);
    if (hopeless != added.spec.after.end()) {
      const Task& before = *table_.find(*hopeless);
      end(added, before.state, blocked_reason(before));
    } else if (added.unmet == 0) {
      enter(added, TaskState::ready);
    }
  }

  void operator()(Restored&& event) {
    if (!table_.by_name.try_emplace(event.task.spec.name, event.task.id).second) return;
    Task& task = table_.tasks.emplace_back(std::move(event.task));
    count_dependencies(task);
    table_.n_waiting += task.state == TaskState::waiting;
    table_.n_ready += task.state == TaskState::ready;
    table_.changed.push_back(task.id);
  }

  void operator()(Placed&& event) {
    Task& task = table_.at(event.attempt.task);
    if (task.state != TaskState::ready || event.attempt.number != task.attempt_id().number + 1) return;
    Attempt attempt;
    attempt.number = event.attempt.number;
    attempt.start = time_;
    attempt.pieces.push_back({time_, -1.0, std::move(event.cores)});
    task.attempts.push_back(std::move(attempt));
    enter(task, TaskState::running);
    if (task.spec.timeout > 0.0) actions_.push_back(SetAlarm{event.attempt, Alarm::timeout, task.spec.timeout});
    actions_.push_back(Spawn{event.attempt});  // last: it may fail at once, which ends all this
  }

  void operator()(const Started& event) {
    if (Task* task = active(event.attempt)) {
      task->attempts.back().pid = event.pid;
      task->attempts.back().start_ticks = event.start_ticks;
    }
  }

  void operator()(const StartFailed& event) {
    Task* task = active(event.attempt);
    if (task == nullptr) return;
    close_attempt(*task, TaskState::failed, event.reason);
    ++task->failures;
    // What could not be started cannot be started a second later either: no retry.
    end(*task, TaskState::failed, event.reason);
  }

  void operator()(const Exited& event) {
    Task* task = active(event.attempt);
    if (task == nullptr) return;
    Attempt& attempt = task->attempts.back();
    attempt.exit_code = event.exit_code;
    attempt.signal = event.signal;
    attempt.cpu_s = event.cpu_s;
    switch (task->ending) {
      case Ending::stop:
      case Ending::stop_resumable:
        task->resumable = task->ending == Ending::stop_resumable;
        close_attempt(*task, TaskState::stopped, task->reason);
        return end(*task, TaskState::stopped, task->reason);
      case Ending::preempt:
        close_attempt(*task, TaskState::stopped, "gave way to a task that needed its cores");
        return enter(*task, TaskState::ready);
      case Ending::lost:
        close_attempt(*task, TaskState::lost, task->reason);
        return enter(*task, TaskState::ready);
      case Ending::timeout:
        return fail(*task, fmt::format("ran longer than its timeout of {:g} s", task->spec.timeout));
      case Ending::none:
        break;
    }
    const std::string fault = fault_of(task->spec, event);
    if (!fault.empty()) return fail(*task, fault);
    close_attempt(*task, TaskState::finished, "");
    finish(*task);
  }

  void operator()(const StopAsked& event) {
    Task& task = table_.at(event.id);
    if (has_ended(task.state)) return;
    if (task.state == TaskState::waiting || task.state == TaskState::ready) {
      if (!event.resumable) end(task, TaskState::stopped, event.reason);
      return;
    }
    if (task.ending == Ending::stop || task.ending == Ending::stop_resumable) return;
    const bool asked_already = task.ending != Ending::none, dying = task.ending == Ending::lost;
    set_ending(task, event.resumable ? Ending::stop_resumable : Ending::stop);
    task.reason = event.reason;
    if (dying) return (*this)(Lost{task.attempt_id(), event.reason});
    if (!asked_already) ask_to_end(task);
  }

  void operator()(const TimedOut& event) {
    Task* task = active(event.attempt);
    if (task == nullptr || task->state != TaskState::running || task->ending != Ending::none) return;
    set_ending(*task, Ending::timeout);
    ask_to_end(*task);
  }

  void operator()(const GraceOver& event) {
    Task* task = active(event.attempt);
    if (task == nullptr || task->ending == Ending::none) return;
    // Nobody may be left who could report the end of what was on a dead node.
    if (task->ending == Ending::lost) return (*this)(Lost{event.attempt, task->reason});
    actions_.push_back(Kill{event.attempt});
  }

  void operator()(const Suspended& event) {
    Task* task = active(event.attempt);
    if (task == nullptr || task->state != TaskState::running || !task->spec.fill || task->ending != Ending::none)
      return;
    task->attempts.back().pieces.back().end = time_;
    enter(*task, TaskState::suspended);
    actions_.push_back(ClearAlarm{event.attempt, Alarm::timeout});
    actions_.push_back(Pause{event.attempt});
  }

  void operator()(const Resumed& event) {
    Task* task = active(event.attempt);
    if (task == nullptr || task->state != TaskState::suspended || task->ending != Ending::none) return;
    Attempt& attempt = task->attempts.back();
    if (task->spec.timeout > 0.0) {
      actions_.push_back(
          SetAlarm{event.attempt, Alarm::timeout, std::max(0.0, task->spec.timeout - attempt.ran(time_))});
    }
    attempt.pieces.push_back({time_, -1.0, event.cores});
    enter(*task, TaskState::running);
    actions_.push_back(Continue{event.attempt});
  }

  void operator()(const Preempted& event) {
    Task* task = active(event.attempt);
    if (task == nullptr || task->state != TaskState::running || !task->spec.fill || task->ending != Ending::none)
      return;
    set_ending(*task, Ending::preempt);
    actions_.push_back(Kill{event.attempt});
  }

  void operator()(const Lost& event) {
    Task* task = active(event.attempt);
    if (task == nullptr) return;
    const Ending ending = task->ending;
    close_attempt(*task, TaskState::lost, event.reason);
    if (ending == Ending::stop) return end(*task, TaskState::stopped, task->reason);
    enter(*task, TaskState::ready);
  }

  void operator()(const Abandoned& event) {
    Task* task = active(event.attempt);
    if (task == nullptr || task->ending == Ending::stop || task->ending == Ending::stop_resumable) return;
    set_ending(*task, Ending::lost);
    task->reason = event.reason;
    actions_.push_back(Kill{event.attempt});
    actions_.push_back(SetAlarm{event.attempt, Alarm::grace, task->spec.stop.grace});
  }

  void operator()(const Reopened& event) {
    Task& task = table_.at(event.id);
    if (task.state != TaskState::stopped || !task.resumable) return;
    task.resumable = false;
    task.reason.clear();
    enter(task, TaskState::ready);
  }

 private:
  /// Counts the dependencies of the newest of all.
  void count_dependencies(Task& task) {
    GRANARY_ASSERT(task.id.value + 1 == static_cast<int>(table_.tasks.size()));
    for (const std::string& name : task.spec.after) {
      const Task* before = table_.find(name);
      GRANARY_ASSERT(before != nullptr, name);
      if (before->state != TaskState::finished) ++task.unmet;
      table_.at(before->id).dependents.push_back(task.id);
    }
  }

  /// The task, if this attempt is the one that runs or is suspended.
  Task* active(AttemptId attempt) {
    if (!table_.has(attempt.task)) return nullptr;
    Task& task = table_.at(attempt.task);
    const bool runs = task.state == TaskState::running || task.state == TaskState::suspended;
    return runs && task.attempt_id() == attempt ? &task : nullptr;
  }

  /// Moves a task from the index of its state to that of the next one.
  void enter(Task& task, TaskState next) {
    table_.changed.push_back(task.id);
    const Turn turn{task.spec.priority, task.id};
    switch (task.state) {
      case TaskState::waiting:
        --table_.n_waiting;
        break;
      case TaskState::ready:
        --table_.n_ready;
        break;
      case TaskState::running:
        table_.running_ids.erase(task.id.value);
        break;
      case TaskState::suspended:
        table_.suspended.erase(turn);
        break;
      default:
        break;
    }
    task.state = next;
    switch (next) {
      case TaskState::waiting:
        ++table_.n_waiting;
        break;
      case TaskState::ready:
        ++table_.n_ready;
        break;
      case TaskState::running:
        table_.running_ids.insert(task.id.value);
        break;
      case TaskState::suspended:
        table_.suspended.insert(turn);
        break;
      default:
        break;
    }
  }

  /// A filler that is being ended lends its cores no more.
  void set_ending(Task& task, Ending ending) {
    task.ending = ending;
    table_.changed.push_back(task.id);
  }

  void ask_to_end(Task& task) {
    actions_.push_back(AskToEnd{task.attempt_id(), stop_signal(task.spec)});
    actions_.push_back(SetAlarm{task.attempt_id(), Alarm::grace, task.spec.stop.grace});
  }

  void close_attempt(Task& task, TaskState outcome, std::string reason) {
    Attempt& attempt = task.attempts.back();
    if (attempt.pieces.back().end < 0.0) attempt.pieces.back().end = time_;
    attempt.end = time_;
    attempt.outcome = outcome;
    attempt.reason = std::move(reason);
    task.ending = Ending::none;
    actions_.push_back(ClearAlarm{task.attempt_id(), Alarm::timeout});
    actions_.push_back(ClearAlarm{task.attempt_id(), Alarm::grace});
  }

  void fail(Task& task, const std::string& reason) {
    close_attempt(task, TaskState::failed, reason);
    ++task.failures;
    if (task.failures <= task.spec.retries) return enter(task, TaskState::ready);
    end(task, TaskState::failed, reason);
  }

  void finish(Task& task) {
    task.reason.clear();
    task.ended = time_;
    enter(task, TaskState::finished);
    actions_.push_back(Report{task.id});
    for (const TaskId id : task.dependents) {
      Task& dependent = table_.at(id);
      --dependent.unmet;
      if (dependent.state == TaskState::waiting && dependent.unmet == 0) enter(dependent, TaskState::ready);
    }
  }

  /// Failed or stopped for good; what waited for it, directly or not, can never start and ends the same way.
  void end(Task& first, TaskState state, const std::string& reason) {
    close(first, state, reason);
    std::vector<TaskId> to_tell{first.id};
    while (!to_tell.empty()) {
      const Task& before = table_.at(to_tell.back());
      to_tell.pop_back();
      if (!never_finishes(before)) continue;
      for (const TaskId id : before.dependents) {
        if (table_.at(id).state != TaskState::waiting) continue;
        close(table_.at(id), state, blocked_reason(before));
        to_tell.push_back(id);
      }
    }
  }

  void close(Task& task, TaskState state, const std::string& reason) {
    task.reason = reason;
    task.ended = time_;
    enter(task, state);
    actions_.push_back(Report{task.id});
  }

  static bool never_finishes(const Task& task) {
    return task.state == TaskState::failed || (task.state == TaskState::stopped && !task.resumable);
  }

  static std::string blocked_reason(const Task& before) {
    return fmt::format("comes after task \"{}\", which {}", before.spec.name,
                       before.state == TaskState::failed ? "failed" : "was stopped");
  }

  static std::string fault_of(const TaskSpec& spec, const Exited& event) {
    if (event.signal != 0) return fmt::format("ended by signal {} ({})", event.signal, strsignal(event.signal));
    if (event.exit_code < 0 || event.exit_code > 255 || !spec.success[static_cast<std::size_t>(event.exit_code)])
      return fmt::format("exit code {}", event.exit_code);
    if (event.missing.empty()) return "";
    std::string names;
    for (const auto& file : event.missing) names += (names.empty() ? "" : ", ") + file.string();
    return fmt::format("ended with exit code {}, but did not produce {}", event.exit_code, names);
  }

  Table& table_;
  double time_;
  std::vector<Action>& actions_;
};

}  // namespace

void update(Table& table, Event event, std::vector<Action>& actions) {
  Step step(table, event.time, actions);
  std::visit(step, std::move(event.what));
}

std::vector<Action> update(Table& table, const Event& event) {
  std::vector<Action> actions;
  update(table, event, actions);
  return actions;
}

}  // namespace granary::pilot
