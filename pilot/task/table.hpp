// All tasks of a campaign, their attempts and their dependencies. Only task/update changes it.
#pragma once

#include <boost/container/deque.hpp>
#include <boost/container/small_vector.hpp>
#include <boost/unordered/unordered_flat_map.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "pilot/task/core_set.hpp"
#include "pilot/task/number_set.hpp"
#include "pilot/task/spec.hpp"
#include "pilot/task/state.hpp"

namespace granary::pilot {

/// A stretch in which an attempt ran without being suspended. `end` < 0: it still runs.
struct Piece {
  double start = 0.0, end = -1.0;
  CoreSet cores;
};

struct Attempt {
  int number = 0;                          ///< from 1
  TaskState outcome = TaskState::running;  ///< running (or suspended) until it has ended
  boost::container::small_vector<Piece, 1> pieces;
  double start = 0.0, end = 0.0;  ///< [s]; `end` once it has ended
  int exit_code = -1, signal = 0;
  double cpu_s = 0.0;
  int pid = 0;
  std::uint64_t start_ticks = 0;
  std::string reason;  ///< why it failed, was stopped or lost

  /// Seconds it ran by `now`, without suspensions.
  double ran(double now) const;
};

/// Why a running attempt is being ended by us.
enum class Ending : char { none, stop, stop_resumable, timeout, preempt, lost };

/// What is looked at often comes first: of a million tasks only few lie in the cache.
struct Task {
  TaskId id;
  TaskState state = TaskState::waiting;
  Ending ending = Ending::none;
  bool resumable = false;  ///< stopped by stop_all()
  int unmet = 0;           ///< dependencies that have not finished
  int failures = 0;        ///< attempts that failed by themselves or by timeout
  double ended = 0.0;      ///< when it ended for good [s]
  boost::container::small_vector<Attempt, 1> attempts;
  std::vector<TaskId> dependents;
  std::string reason;  ///< why it is being stopped; of an ended task: why it failed or was stopped
  TaskSpec spec;

  const Attempt& last() const { return attempts.back(); }
  AttemptId attempt_id() const { return {id, attempts.empty() ? 0 : attempts.back().number}; }
};

/// Larger priority first, then the order of submission.
struct Turn {
  int priority = 0;
  TaskId id;
  bool operator<(const Turn& other) const {
    return priority != other.priority ? priority > other.priority : id < other.id;
  }
};

struct Table {
  using Tasks =
      boost::container::deque<Task, void, boost::container::deque_options_t<boost::container::block_size<64>>>;
  Tasks tasks;  ///< by id; they stay where they are
  boost::unordered_flat_map<std::string, TaskId> by_name;
  // Indices of `tasks` by state, so that nothing walks through all of them.
  NumberSet running_ids;
  std::set<Turn> suspended;
  std::size_t n_waiting = 0, n_ready = 0;
  std::vector<TaskId> changed;  ///< state or ending has changed since the scheduler looked; some several times

  Task& at(TaskId id) { return tasks.at(static_cast<std::size_t>(id.value)); }
  const Task& at(TaskId id) const { return tasks.at(static_cast<std::size_t>(id.value)); }
  std::vector<TaskId> running() const;  ///< by id
  const Task* find(const std::string& name) const;
  bool has(TaskId id) const { return id.value >= 0 && static_cast<std::size_t>(id.value) < tasks.size(); }
  /// What must hold after every event; the error names what does not. Cost: all tasks; for tests.
  Status check_invariants() const;
};

}  // namespace granary::pilot
