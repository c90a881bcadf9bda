// The states of a task, and what is known of it when it has ended.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "pilot/task/core_set.hpp"
#include "pilot/task/spec.hpp"

namespace granary::pilot {

///   waiting -> ready -> running <-> suspended (fillers)
///                          |
///                          +-> finished | failed | stopped;   lost and failed with retries left: back to ready
enum class TaskState : char { waiting, ready, running, suspended, finished, failed, stopped, lost };

std::string_view name_of(TaskState state);
inline bool has_ended(TaskState state) {
  return state == TaskState::finished || state == TaskState::failed || state == TaskState::stopped;
}

/// A task that has ended for good. Times: pilot time [s].
struct TaskEnd {
  TaskId id;
  std::string name;
  TaskState state = TaskState::finished;  ///< finished (exit code 0, everything produced) | failed | stopped
  int exit_code = -1;                     ///< of the last attempt; -1: ended by a signal or never started
  int signal = 0;                         ///< that ended it; 0: none
  int attempt = 0;                        ///< number of the last attempt, from 1; 0: never started
  double start = 0.0;                     ///< of the last attempt [s]
  double end = 0.0;                       ///< [s]
  CoreSet cores;                          ///< core indices of the machine that it ran on
  double cpu_s = 0.0;                     ///< CPU time of the task's processes [s]
  std::filesystem::path dir;              ///< absolute working folder
  std::string reason;                     ///< in words, why it failed or was stopped; empty if finished
};

}  // namespace granary::pilot
