// The beginning of a pilot's life: the journal is replayed, orphans are ended, a long journal is compacted.
#include <unistd.h>

#include <random>

#include "common/version.hpp"
#include "pilot/pilot_state.hpp"
#include "pilot/schedule/check_tasks.hpp"
#include "pilot/task/past.hpp"

namespace granary::pilot {
namespace {

std::string new_run_id() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

}  // namespace

Status Pilot::State::replay(const Line& line) {
  const bool of_task = line.kind.starts_with("task.");
  if (!of_task && !line.kind.starts_with("pilot.")) return {};
  const auto broken = [&](const std::string& what) {
    return Error{fmt::format("journal.jsonl: record {} ({}): {}", line.sequence, line.kind, what)};
  };
  const auto payload = json::parse_text(line.payload);
  if (!payload) return broken("its payload is not JSON");
  if (line.kind == "pilot.open" && run_id.empty()) run_id = payload->text_or("run_id", "");
  time_base = std::max(time_base, payload->number_or("time_s", 0.0));
  if (!of_task) return {};
  const auto event = event_from_json(line.kind, *payload);
  if (!event) return broken(event.error().message);
  if (!belongs_here(*event, TaskId{static_cast<int>(payload->integer_or("id", -1))}))
    return broken("tells of a task that no earlier record submitted; somebody put this file together from others");
  (void)update(table, *event);
  return {};
}

Status Pilot::State::replay() {
  GRANARY_CHECK(journal.for_each([this](const Line& line) { return replay(line); }));
  for (const Task& task : table.tasks) {
    count_folder(task.spec);
    if (has_ended(task.state) && !task.resumable) continue;
    if (const Status fits = check_fits(task.spec, scheduler.layouts()); !fits) {
      return Error{fmt::format("task \"{}\" {}", task.spec.name, fits.error().message)};
    }
  }
  return {};
}

bool Pilot::State::belongs_here(const Event& event, TaskId id) const {
  const auto* submitted = std::get_if<Submitted>(&event.what);
  const auto* restored = std::get_if<Restored>(&event.what);
  if (submitted == nullptr && restored == nullptr) return table.has(id);
  const auto is_known = [this](const std::string& name) { return table.find(name) != nullptr; };
  const auto& after = submitted != nullptr ? submitted->spec.after : restored->task.spec.after;
  return id.value == static_cast<int>(table.tasks.size()) && std::all_of(after.begin(), after.end(), is_known);
}

Status Pilot::State::begin() {
  const bool is_new = journal.n_records() == 0;
  if (run_id.empty()) run_id = new_run_id();
  json::Value nodes = json::Value::array();
  for (const Node& node : options.machine.nodes) {
    nodes.push(json::Value::object({{"name", node.name}, {"cores", node.cpus.size()}}));
  }
  opening = json::Value::object({{"time_s", now()},
                                 {"run_id", run_id},
                                 {"pid", static_cast<int>(getpid())},
                                 {"version", version()},
                                 {"nodes", std::move(nodes)}});
  record("pilot.open", opening);
  if (!is_new) take_up();
  GRANARY_CHECK(flush());
  GRANARY_CHECK(journal.healthy());
  if (journal.n_records() <= options.compact_above || journal.n_records() <= 2 * table.tasks.size()) return {};
  return compact();
}

/// Rewrites the journal with one record a task; what others have written stays as it is. Nothing runs now.
Status Pilot::State::compact() {
  Status read;
  const Status written = journal.rewrite([&](Journal& fresh) {
    bool first = true;
    const auto keep = [&](const Line& line) {
      const bool ours =
          line.kind.starts_with("task.") || line.kind.starts_with("pilot.") || line.kind.starts_with("node.");
      if (!ours || std::exchange(first, false)) {
        fresh.stamp_with(line.wall_time);
        fresh.add(line.kind, line.payload);
      }
      return Status();
    };
    read = journal.for_each(keep);
    fresh.stamp_with(std::nullopt);
    for (const Task& task : table.tasks) {
      const Event event{now(), Restored{task}};
      text.clear();
      append(text, event);
      fresh.add(kind_of(event), text);
    }
    text.clear();
    json::append(text, opening);
    fresh.add("pilot.open", text);
  });
  GRANARY_CHECK(read);
  return written;
}

void Pilot::State::take_up() {
  for (const TaskId id : active_tasks()) {
    const Task& task = table.at(id);
    const bool was_alive = launcher.end_orphan({task.last().pid, task.last().start_ticks}, mark_of(task.attempt_id()));
    happens({now(), Lost{task.attempt_id(),
                         was_alive ? "the pilot died; the task still ran and was ended" : "the pilot died under it"}});
  }
  for (std::size_t k = 0; k < table.tasks.size(); ++k) {
    if (table.tasks[k].resumable) happens({now(), Reopened{table.tasks[k].id}});
  }
  todo.clear();  // what ended in an earlier life was told there
  idle_told = false;
  turn_soon();
}

}  // namespace granary::pilot
