// Runs a plain list of tasks (a workflow of kind "tasks") to its end, for real or simulated.
#pragma once

#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "pilot/pilot.hpp"

namespace granary::pilot {

struct TaskListSummary {
  Exit exit = Exit::ok;       ///< ok; task_failed if one failed; stopped if it can be resumed
  std::vector<TaskEnd> ends;  ///< by id
  int finished = 0, failed = 0, stopped = 0, not_started = 0;
  double seconds = 0.0;  ///< pilot time [s]
  Usage usage;
  json::Value json() const;
};

/// Submits all, runs the loop until the pilot is idle, sums up. Fillers left when all else has ended run to their end
/// too. Errors: a task that cannot be submitted; the journal cannot be written.
Result<TaskListSummary> run_task_list(const std::vector<TaskSpec>& tasks, Pilot& pilot, EventLoop& loop);

}  // namespace granary::pilot
