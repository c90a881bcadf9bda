#include "pilot/task_list.hpp"

#include <algorithm>
#include <set>

namespace granary::pilot {
namespace {

/// Tasks in an order in which each comes after those it depends on; else as in the document. Those of a circle come
/// last: submitting them says what is wrong.
std::vector<const TaskSpec*> in_order_of_dependency(const std::vector<TaskSpec>& tasks) {
  std::vector<const TaskSpec*> ordered, left;
  std::set<std::string> placed;
  for (const TaskSpec& task : tasks) left.push_back(&task);
  while (!left.empty()) {
    std::vector<const TaskSpec*> blocked;
    for (const TaskSpec* task : left) {
      const auto is_placed = [&](const std::string& name) { return placed.count(name) != 0; };
      if (std::all_of(task->after.begin(), task->after.end(), is_placed)) {
        ordered.push_back(task);
        placed.insert(task->name);
      } else {
        blocked.push_back(task);
      }
    }
    if (blocked.size() == left.size()) {
      ordered.insert(ordered.end(), blocked.begin(), blocked.end());
      break;
    }
    left = std::move(blocked);
  }
  return ordered;
}

}  // namespace

Result<TaskListSummary> run_task_list(const std::vector<TaskSpec>& tasks, Pilot& pilot, EventLoop& loop) {
  for (const TaskSpec* task : in_order_of_dependency(tasks)) {
    GRANARY_TRY(const TaskId id, pilot.submit(*task));
    (void)id;
  }
  pilot.on_idle([&loop] { loop.stop(); });
  if (!pilot.idle()) loop.run();
  if (pilot.failure()) return *pilot.failure();

  TaskListSummary summary;
  summary.ends = pilot.ends();
  summary.seconds = pilot.now();
  summary.usage = pilot.usage();
  for (const TaskEnd& end : summary.ends) {
    summary.finished += end.state == TaskState::finished;
    summary.failed += end.state == TaskState::failed;
    summary.stopped += end.state == TaskState::stopped;
  }
  summary.not_started = static_cast<int>(tasks.size() - std::min(tasks.size(), summary.ends.size()));
  if (pilot.stopping()) {
    summary.exit = Exit::stopped;
  } else if (summary.failed > 0) {
    summary.exit = Exit::task_failed;
  }
  return summary;
}

json::Value TaskListSummary::json() const {
  json::Value list = json::Value::array();
  for (const TaskEnd& end : ends) {
    json::Value cores = json::Value::array();
    end.cores.for_each([&](int core) { cores.push(core); });
    list.push(json::Value::object({{"name", end.name},
                                   {"state", name_of(end.state)},
                                   {"exit_code", end.exit_code},
                                   {"signal", end.signal},
                                   {"attempt", end.attempt},
                                   {"start_s", end.start},
                                   {"end_s", end.end},
                                   {"cores", std::move(cores)},
                                   {"cpu_s", end.cpu_s},
                                   {"dir", end.dir.string()},
                                   {"reason", end.reason}}));
  }
  const char* ended = exit == Exit::ok ? "finished" : exit == Exit::stopped ? "stopped" : "failed";
  return json::Value::object({{"ended", ended},
                              {"finished", finished},
                              {"failed", failed},
                              {"stopped", stopped},
                              {"not_started", not_started},
                              {"wall_s", seconds},
                              {"core_use", usage.total > 0.0 ? usage.busy / usage.total : 0.0},
                              {"core_use_fillers", usage.total > 0.0 ? usage.fillers / usage.total : 0.0},
                              {"tasks", std::move(list)}});
}

}  // namespace granary::pilot
