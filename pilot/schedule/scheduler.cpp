#include "pilot/schedule/scheduler.hpp"

#include <algorithm>
#include <set>

#include "pilot/schedule/placement.hpp"

namespace granary::pilot {
namespace {

class Scheduler {
 public:
  Scheduler(const Table& table, const Resources& resources)
      : table_(table), resources_(resources), use_(static_cast<std::size_t>(resources.n_cores())), reserved_(use_.size(), false) {
    for (int core = 0; core < resources.n_cores(); ++core) {
      const TaskId holder = resources.holder(core);
      use_[index(core)] = holder == TaskId{} ? Use::free : gives_way(holder) ? Use::filler : Use::taken;
    }
  }

  std::vector<Decision> decide() {
    for (const Turn& turn : table_.ready_light) decisions_.push_back(StartTask{turn.id, {}});
    start_ready_tasks();
    run_fillers();
    return std::move(decisions_);
  }

 private:
  static std::size_t index(int core) { return static_cast<std::size_t>(core); }

  bool gives_way(TaskId id) const {
    const Task& task = table_.at(id);
    return task.spec.fill && task.state == TaskState::running && task.ending == Ending::none;
  }

  /// What a task at this point of the order may use: nothing that an earlier one waits for.
  std::vector<Use> unreserved() const {
    std::vector<Use> use = use_;
    for (std::size_t k = 0; k < use.size(); ++k) {
      if (reserved_[k]) use[k] = Use::taken;
    }
    return use;
  }

  void start_ready_tasks() {
    for (const Turn& turn : table_.ready) {
      const std::vector<Use> use = unreserved();
      if (std::count(use.begin(), use.end(), Use::taken) == static_cast<std::ptrdiff_t>(use.size())) return;
      const Task& task = table_.at(turn.id);
      if (const auto cores = choose_cores(task.spec, resources_, use); cores && clear(*cores)) {
        for (const int core : *cores) use_[index(core)] = Use::taken;
        decisions_.push_back(StartTask{task.id, *cores});
      } else {
        const std::vector<int> wanted = cores ? *cores : cores_to_wait_for(task.spec, resources_, use, reserved_);
        for (const int core : wanted) reserved_[index(core)] = true;
      }
    }
  }

  /// Makes the fillers on these cores give way. False if one of them has to end first.
  bool clear(const std::vector<int>& cores) {
    bool all_clear = true;
    std::set<TaskId> fillers;
    for (const int core : cores) {
      if (use_[index(core)] == Use::filler) fillers.insert(resources_.holder(core));
    }
    for (const TaskId id : fillers) {
      const bool suspends = table_.at(id).spec.preempt == Preempt::suspend;
      if (suspends) {
        decisions_.push_back(SuspendFiller{id});
        suspended_now_.insert(id);
      } else {
        decisions_.push_back(KillFiller{id});
        all_clear = false;
      }
      for (int core = 0; core < resources_.n_cores(); ++core) {
        if (resources_.holder(core) == id) use_[index(core)] = suspends ? Use::free : Use::taken;
      }
    }
    return all_clear;
  }

  /// Suspended and ready fillers, by priority; at equal priority those that have begun go first.
  void run_fillers() {
    auto suspended = table_.suspended.begin();
    auto ready = table_.ready_fillers.begin();
    // Fillers never push each other away: their cores count as taken from here on.
    std::replace(use_.begin(), use_.end(), Use::filler, Use::taken);
    while (std::find(use_.begin(), use_.end(), Use::free) != use_.end()) {
      const bool more_suspended = suspended != table_.suspended.end(), more_ready = ready != table_.ready_fillers.end();
      if (!more_suspended && !more_ready) return;
      if (more_suspended && (!more_ready || suspended->priority >= ready->priority)) {
        resume(table_.at((suspended++)->id));
      } else if (!start_filler(table_.at((ready++)->id))) {
        ready = table_.ready_fillers.end();  // the next ones would overtake it for ever
      }
    }
  }

  void resume(const Task& task) {
    if (task.ending != Ending::none || suspended_now_.count(task.id) != 0) return;
    std::vector<int> cores = task.last().pieces.back().cores;
    const auto is_free = [this](int core) { return use_[index(core)] == Use::free; };
    if (!std::all_of(cores.begin(), cores.end(), is_free)) {
      const auto moved = other_cores(task, cores);
      if (!moved) return;
      cores = *moved;
    }
    take(cores);
    decisions_.push_back(ResumeFiller{task.id, cores});
  }

  /// As many free cores of the same nodes, for a process can be moved to other cores but not to another node.
  std::optional<std::vector<int>> other_cores(const Task& task, const std::vector<int>& held) const {
    std::vector<int> moved;
    for (int node = 0; node < resources_.n_nodes(); ++node) {
      const auto on_node = [&](int core) { return resources_.node_of(core) == node; };
      auto missing = std::count_if(held.begin(), held.end(), on_node);
      for (int core = resources_.first_core(node); core < resources_.end_core(node) && missing > 0; ++core) {
        if (use_[index(core)] != Use::free) continue;
        moved.push_back(core);
        --missing;
      }
      if (missing > 0) return std::nullopt;
    }
    GRANARY_ASSERT(static_cast<int>(moved.size()) == task.spec.cores());
    return moved;
  }

  bool start_filler(const Task& task) {
    const auto cores = choose_cores(task.spec, resources_, use_);
    if (!cores) return false;
    take(*cores);
    decisions_.push_back(StartTask{task.id, *cores});
    return true;
  }

  void take(const std::vector<int>& cores) {
    for (const int core : cores) use_[index(core)] = Use::taken;
  }

  const Table& table_;
  const Resources& resources_;
  std::vector<Use> use_;
  std::vector<bool> reserved_;
  std::set<TaskId> suspended_now_;
  std::vector<Decision> decisions_;
};

}  // namespace

std::vector<Decision> schedule(const Table& table, const Resources& resources) {
  if (table.n_ready() == 0 && table.suspended.empty()) return {};
  return Scheduler(table, resources).decide();
}

}  // namespace granary::pilot
