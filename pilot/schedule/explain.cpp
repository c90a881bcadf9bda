#include "pilot/schedule/explain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

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
  for (const TaskId id : table.running()) {
    const Task& other = table.at(id);
    const auto& cores = other.last().pieces.back().cores;
    if (cores.empty()) continue;
    text += fmt::format("{}\"{}\"{} on {}", text.empty() ? "" : "; ", other.spec.name,
                        other.spec.fill ? " (filler)" : "", cores.text());
  }
  return fmt::format("{} of {} cores are free{}{}", resources.n_free(), resources.n_cores(), text.empty() ? "" : ": ",
                     text);
}

/// Ready tasks of the same kind that go before it, and those that go before any filler.
struct Ahead {
  int same_kind = 0, no_fillers = 0;
};
Ahead ahead_of(const Task& task, const Table& table) {
  Ahead ahead;
  const Turn turn{task.spec.priority, task.id};
  for (const Task& other : table.tasks) {
    if (other.state != TaskState::ready || other.spec.light) continue;
    ahead.no_fillers += !other.spec.fill;
    ahead.same_kind += other.spec.fill == task.spec.fill && Turn{other.spec.priority, other.id} < turn;
  }
  return ahead;
}

std::string promised(const Reservation& reservation, double now, const Machine& machine) {
  std::string nodes;
  for (std::size_t k = 0; k < reservation.parts.size() && k < 4; ++k)
    nodes += (k > 0 ? ", " : "") + machine.nodes[static_cast<std::size_t>(reservation.parts[k].node)].name;
  if (reservation.parts.size() > 4) nodes += fmt::format(" and {} more", reservation.parts.size() - 4);
  return fmt::format("; its cores are reserved on {}{}", nodes,
                     reservation.start < std::numeric_limits<double>::infinity()
                         ? fmt::format(", in {:.3g} s at the latest", std::max(0.0, reservation.start - now))
                         : "");
}

std::string ready(const Task& task, const Table& table, const Scheduler& scheduler, double now, bool stopping) {
  if (stopping) return "does not start: the pilot is stopping";
  if (scheduler.is_late(task.id))
    return fmt::format("does not start: it may run for {:g} s, and the allocation ends before", task.spec.duration());
  if (scheduler.waits_for_fillers(task.id)) return "starts as soon as the fillers on its cores have been ended";
  const Resources& resources = scheduler.resources();
  std::string text = fmt::format("ready; needs {} core(s)", task.spec.cores());
  if (task.spec.memory_bytes > 0)
    text += fmt::format(" and {:.3g} GB", static_cast<double>(task.spec.memory_bytes) * 1e-9);
  text += ", " + holders(table, resources);
  if (resources.n_down() > 0) text += fmt::format("; {} node(s) are lost", resources.n_down());
  const Ahead ahead = ahead_of(task, table);
  if (ahead.same_kind > 0)
    text += fmt::format("; {} task(s) go before it (priority, then order of submission)", ahead.same_kind);
  if (const auto& reservation = scheduler.reservation(); reservation && reservation->task == task.id)
    text += promised(*reservation, now, resources.machine());
  if (task.spec.fill)
    text += fmt::format("; a filler starts only when no other task ({} ready) wants the cores", ahead.no_fillers);
  return text;
}

std::string attempt_line(const Attempt& attempt, double now, bool active, TaskState state) {
  const CoreSet& cores = attempt.pieces.back().cores;
  const std::string where = cores.empty() ? "no core of its own" : fmt::format("core(s) {}", cores.text());
  std::string text = fmt::format("attempt {}: {} for {:.3g} s on {} from {:.3f} s", attempt.number,
                                 name_of(active ? state : attempt.outcome), attempt.ran(now), where, attempt.start);
  if (attempt.pieces.size() > 1) text += fmt::format(", gave way {} time(s)", attempt.pieces.size() - 1);
  if (active && attempt.pid > 0) text += fmt::format(", pid {}", attempt.pid);
  if (!active)
    text += fmt::format("; {:.3g} core seconds, {:.3g} s of CPU", attempt.ran(now) * cores.size(), attempt.cpu_s);
  if (!attempt.reason.empty()) text += "; " + attempt.reason;
  return text;
}

}  // namespace

std::string explain(const Task& task, const Table& table, const Scheduler& scheduler, double now, bool stopping) {
  const bool active = task.state == TaskState::running || task.state == TaskState::suspended;
  std::string text = fmt::format("{}: ", task.spec.name);
  switch (task.state) {
    case TaskState::waiting:
      text += waiting_for(task, table);
      break;
    case TaskState::ready:
      text += ready(task, table, scheduler, now, stopping);
      break;
    case TaskState::running:
      text += task.ending == Ending::none ? "running" : "running, asked to end: " + task.reason;
      break;
    case TaskState::suspended:
      text += "suspended: it is a filler, and other tasks need its cores; " + holders(table, scheduler.resources());
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
