#include "pilot/schedule/explain.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace granary::pilot {
namespace {

std::string waiting_for(const Task& task, const Table& table) {
  std::string text = "waits for ";
  bool first = true;
  for (const std::string& name : task.spec.after) {
    const Task& before = *table.find(name);
    if (before.state == TaskState::finished) continue;
    text += fmt::format("{}\"{}\" ({})", first ? "" : ", ", name, name_of(before.state));
    first = false;
  }
  return text + " to finish";
}

/// What holds the machine: "3 of 4 cores are busy: dem on 0,1; pbm on 2".
std::string holders(const Table& table, const Resources& resources) {
  std::string text;
  for (const TaskId id : table.running) {
    const Task& other = table.at(id);
    const auto& cores = other.last().pieces.back().cores;
    if (cores.empty()) continue;
    text += fmt::format("{}\"{}\"{} on {}", text.empty() ? "" : "; ", other.spec.name,
                        other.spec.fill ? " (filler)" : "", fmt::join(cores, ","));
  }
  return fmt::format("{} of {} cores are free{}{}", resources.n_free(), resources.n_cores(), text.empty() ? "" : ": ",
                     text);
}

std::string ready(const Task& task, const Table& table, const Resources& resources, bool stopping) {
  if (stopping) return "does not start: the pilot is stopping";
  const Turn turn{task.spec.priority, task.id};
  const std::set<Turn>& queue = task.spec.light  ? table.ready_light
                                : task.spec.fill ? table.ready_fillers
                                                 : table.ready;
  const auto before = std::distance(queue.begin(), queue.find(turn));
  std::string text = fmt::format("ready; needs {} core(s)", task.spec.cores());
  if (task.spec.memory_bytes > 0)
    text += fmt::format(" and {:.3g} GB", static_cast<double>(task.spec.memory_bytes) * 1e-9);
  text += ", " + holders(table, resources);
  if (before > 0) text += fmt::format("; {} task(s) go before it (priority, then order of submission)", before);
  if (task.spec.fill)
    text += fmt::format("; a filler starts only when no other task ({} ready) wants the cores", table.ready.size());
  return text;
}

std::string attempt_line(const Attempt& attempt, double now, bool active, TaskState state) {
  const std::vector<int>& cores = attempt.pieces.back().cores;
  const std::string where = cores.empty() ? "no core of its own" : fmt::format("core(s) {}", fmt::join(cores, ","));
  std::string text = fmt::format("attempt {}: {} for {:.3g} s on {} from {:.3f} s", attempt.number,
                                 name_of(active ? state : attempt.outcome), attempt.ran(now), where, attempt.start);
  if (attempt.pieces.size() > 1) text += fmt::format(", gave way {} time(s)", attempt.pieces.size() - 1);
  if (active && attempt.pid > 0) text += fmt::format(", pid {}", attempt.pid);
  if (!active)
    text += fmt::format("; {:.3g} core seconds, {:.3g} s of CPU", attempt.ran(now) * static_cast<double>(cores.size()),
                        attempt.cpu_s);
  if (!attempt.reason.empty()) text += "; " + attempt.reason;
  return text;
}

}  // namespace

std::string explain(const Task& task, const Table& table, const Resources& resources, double now, bool stopping) {
  const bool active = task.state == TaskState::running || task.state == TaskState::suspended;
  std::string text = fmt::format("{}: ", task.spec.name);
  switch (task.state) {
    case TaskState::waiting:
      text += waiting_for(task, table);
      break;
    case TaskState::ready:
      text += ready(task, table, resources, stopping);
      break;
    case TaskState::running:
      text += task.ending == Ending::none ? "running" : "running, asked to end: " + task.reason;
      break;
    case TaskState::suspended:
      text += "suspended: it is a filler, and other tasks need its cores; " + holders(table, resources);
      break;
    default:
      text += fmt::format("{}{}{}", name_of(task.state), task.reason.empty() ? "" : ": ", task.reason);
  }
  text += "\n";
  for (const Attempt& attempt : task.attempts) {
    text += "  " + attempt_line(attempt, now, active && attempt.number == task.last().number, task.state) + "\n";
  }
  return text;
}

}  // namespace granary::pilot
