// The scheduler's last step: fillers on what is idle.
#include <algorithm>

#include "pilot/schedule/scheduler.hpp"

namespace granary::pilot {

/// Suspended and ready fillers, by priority; at equal priority those that have begun go first.
void Scheduler::run_fillers() {
  bool blocked = false;
  int resumed_down_to = std::numeric_limits<int>::max();
  while (resources_.n_free() > 0) {
    const auto first = blocked ? std::nullopt : fillers_.first();
    const int priority = first ? table_.at(*first).spec.priority : std::numeric_limits<int>::min();
    if (priority < resumed_down_to) resume_fillers(resumed_down_to = priority);
    if (!first) return;
    // If it does not fit, the next ones would overtake it for ever.
    if (!set_late_aside(*first)) blocked = !start_filler(table_.at(*first));
  }
}

/// On idle cores only: fillers never push each other away.
bool Scheduler::start_filler(const Task& task) {
  const Layout& layout = fillers_.layout(task.id);
  const bool spread = task.spec.placement == Placement::spread;
  auto parts = places(layout, spread, resources_.spare_idle(), true);
  if (!parts) parts = places(layout, spread, resources_.reserved_idle(), true);
  if (!parts) return false;
  const CoreSet cores = pick(*parts);
  fillers_.erase(task);
  book(task, cores);
  decisions_.push_back(StartTask{task.id, cores});
  return true;
}

/// A suspended filler goes on on its own cores, or on others of the same nodes: a process can be moved to other cores
/// but not to another node.
void Scheduler::resume_fillers(int lowest_priority) {
  for (const Turn& turn : table_.suspended) {
    if (resources_.n_free() == 0 || turn.priority < lowest_priority) return;
    const Task& task = table_.at(turn.id);
    const bool decided_already = resources_.held_by(task.id) != nullptr || suspended_now_.count(task.id) != 0;
    if (task.ending != Ending::none || decided_already) continue;
    CoreSet cores = task.last().pieces.back().cores;
    std::map<int, int> count;
    bool same = true;
    cores.for_each([&](int core) {
      ++count[resources_.node_of(core)];
      same = same && resources_.is_idle(core);
    });
    const auto has_room = [&](const auto& part) {
      return resources_.is_up(part.first) && resources_.idle(part.first) >= part.second;
    };
    if (!std::all_of(count.begin(), count.end(), has_room)) continue;
    if (!same) {
      Parts parts;
      for (const auto& [node, n] : count) parts.push_back({node, n});
      cores = pick(parts);
    }
    book(task, cores);
    decisions_.push_back(ResumeFiller{task.id, cores});
  }
}

}  // namespace granary::pilot
