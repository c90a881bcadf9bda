#include "pilot/summary.hpp"

#include <map>

namespace granary::pilot {

TaskEnd end_of(const Task& task, std::filesystem::path dir) {
  TaskEnd end;
  end.id = task.id;
  end.name = task.spec.name;
  end.state = task.state;
  end.start = end.end = task.ended;
  end.dir = std::move(dir);
  end.reason = task.reason;
  if (task.attempts.empty()) return end;
  const Attempt& last = task.last();
  end.exit_code = last.exit_code;
  end.signal = last.signal;
  end.attempt = last.number;
  end.start = last.start;
  end.cores = last.pieces.back().cores;
  end.cpu_s = last.cpu_s;
  return end;
}

Usage usage_of(const Table& table, int n_cores, double now) {
  Usage usage;
  usage.total = n_cores * now;
  for (const Task& task : table.tasks) {
    double busy = 0.0;
    for (const Attempt& attempt : task.attempts) busy += attempt.ran(now) * task.spec.cores();
    usage.busy += busy;
    if (task.spec.fill) usage.fillers += busy;
  }
  return usage;
}

std::vector<Interval> timeline_of(const Table& table, double now) {
  std::vector<Interval> timeline;
  for (const Task& task : table.tasks) {
    for (const Attempt& attempt : task.attempts) {
      for (std::size_t p = 0; p < attempt.pieces.size(); ++p) {
        const Piece& piece = attempt.pieces[p];
        const bool ended = piece.end >= 0.0, last = p + 1 == attempt.pieces.size();
        const TaskState outcome =
            !last || (ended && attempt.outcome == TaskState::running) ? TaskState::suspended : attempt.outcome;
        timeline.push_back({task.id, task.spec.name, attempt.number, task.spec.fill, piece.cores.list(), piece.start,
                            ended ? piece.end : now, ended, outcome});
      }
    }
  }
  return timeline;
}

json::Value status_of(const Table& table, const Resources& resources, double now) {
  std::map<std::string, int> counts;
  json::Value active = json::Value::array();
  for (const Task& task : table.tasks) {
    ++counts[std::string(name_of(task.state))];
    if (task.state != TaskState::running && task.state != TaskState::suspended) continue;
    json::Value cores = json::Value::array();
    task.last().pieces.back().cores.for_each([&](int core) { cores.push(core); });
    active.push(json::Value::object({{"name", task.spec.name},
                                     {"state", name_of(task.state)},
                                     {"attempt", task.last().number},
                                     {"fill", task.spec.fill},
                                     {"cores", std::move(cores)},
                                     {"seconds", task.last().ran(now)},
                                     {"pid", task.last().pid}}));
  }
  json::Value counted = json::Value::object();
  for (const auto& [state, count] : counts) counted.set(state, count);
  const Usage usage = usage_of(table, resources.n_cores(), now);
  return json::Value::object({{"time_s", now},
                              {"cores", resources.n_cores()},
                              {"busy_cores", resources.n_cores() - resources.n_free()},
                              {"core_use", usage.total > 0.0 ? usage.busy / usage.total : 0.0},
                              {"core_use_fillers", usage.total > 0.0 ? usage.fillers / usage.total : 0.0},
                              {"counts", std::move(counted)},
                              {"tasks", std::move(active)}});
}

}  // namespace granary::pilot
