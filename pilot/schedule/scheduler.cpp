#include "pilot/schedule/scheduler.hpp"

#include <algorithm>
#include <set>

#include "pilot/schedule/placement.hpp"

namespace granary::pilot {
namespace {

class Scheduler {
 public:
  Scheduler(const Table& table, const Resources& resources, double time_left)
      : table_(table),
        resources_(resources),
        time_left_(time_left),
        use_(static_cast<std::size_t>(resources.n_cores())),
        reserved_(use_.size(), false) {
    for (int node = 0; node < resources.n_nodes(); ++node) memory_.push_back(resources.free_memory(node));
    for (int core = 0; core < resources.n_cores(); ++core) {
      const TaskId holder = resources.holder(core);
      use_[index(core)] = holder == TaskId{} ? Use::free : use_of(table_.at(holder));
      if (!resources.is_up(resources.node_of(core))) use_[index(core)] = Use::taken;
    }
  }

  std::vector<Decision> decide() {
    for (const Turn& turn : table_.ready_light) {
      if (ends_in_time(table_.at(turn.id).spec)) decisions_.push_back(StartTask{turn.id, {}});
    }
    start_ready_tasks();
    run_fillers();
    return std::move(decisions_);
  }

 private:
  /// A task of unknown duration may; one that can be stopped and resumed need not end at all.
  bool ends_in_time(const TaskSpec& spec) const { return spec.resumable || spec.duration() <= time_left_; }

  static std::size_t index(int core) { return static_cast<std::size_t>(core); }

  static Use use_of(const Task& holder) {
    if (holder.ending == Ending::preempt) return Use::leaving;
    return holder.spec.fill && holder.ending == Ending::none ? Use::filler : Use::taken;
  }

  /// What a task at this point of the order may use: nothing that an earlier one waits for.
  Availability unreserved() const {
    Availability available{use_, memory_};
    for (std::size_t k = 0; k < use_.size(); ++k) {
      if (reserved_[k]) available.use[k] = Use::taken;
    }
    return available;
  }

  void start_ready_tasks() {
    for (const Turn& turn : table_.ready) {
      const Availability available = unreserved();
      const auto taken = std::count(available.use.begin(), available.use.end(), Use::taken);
      if (taken == static_cast<std::ptrdiff_t>(available.use.size())) return;
      const Task& task = table_.at(turn.id);
      if (!ends_in_time(task.spec)) continue;
      if (const auto cores = choose_cores(task.spec, resources_, available); cores && clear(*cores)) {
        start(task, *cores);
      } else {
        const auto wanted = cores ? *cores : cores_to_wait_for(task.spec, resources_, available.use, reserved_);
        for (const int core : wanted) reserved_[index(core)] = true;
      }
    }
  }

  /// Makes the fillers on these cores give way. False if one of them has to end first; the others then go on until it
  /// has.
  bool clear(const std::vector<int>& cores) {
    bool one_leaves = false;
    std::set<TaskId> to_suspend, to_kill;
    for (const int core : cores) {
      one_leaves = one_leaves || use_[index(core)] == Use::leaving;
      if (use_[index(core)] != Use::filler) continue;
      const TaskId holder = resources_.holder(core);
      (table_.at(holder).spec.preempt == Preempt::suspend ? to_suspend : to_kill).insert(holder);
    }
    for (const TaskId id : to_kill) {
      decisions_.push_back(KillFiller{id});
      mark_cores_of(id, Use::leaving);
    }
    if (one_leaves || !to_kill.empty()) return false;
    for (const TaskId id : to_suspend) {
      decisions_.push_back(SuspendFiller{id});
      mark_cores_of(id, Use::free);
      suspended_now_.insert(id);
    }
    return true;
  }

  void mark_cores_of(TaskId id, Use use) {
    for (const int core : table_.at(id).last().pieces.back().cores) use_[index(core)] = use;
  }

  void start(const Task& task, const std::vector<int>& cores) {
    take(cores);
    Availability available{{}, std::move(memory_)};
    take_memory(task.spec, cores, resources_, available);
    memory_ = std::move(available.free_memory);
    decisions_.push_back(StartTask{task.id, cores});
  }

  /// Suspended and ready fillers, by priority; at equal priority those that have begun go first.
  void run_fillers() {
    auto suspended = table_.suspended.begin();
    auto ready = table_.ready_fillers.begin();
    // Fillers never push each other away: their cores count as taken from here on.
    for (Use& use : use_) use = use == Use::free ? Use::free : Use::taken;
    while (std::find(use_.begin(), use_.end(), Use::free) != use_.end()) {
      const bool more_suspended = suspended != table_.suspended.end(), more_ready = ready != table_.ready_fillers.end();
      if (!more_suspended && !more_ready) return;
      if (more_suspended && (!more_ready || suspended->priority >= ready->priority)) {
        resume(table_.at((suspended++)->id));
      } else if (const Task& next = table_.at((ready++)->id); ends_in_time(next.spec) && !start_filler(next)) {
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
    const auto cores = choose_cores(task.spec, resources_, {use_, memory_});
    if (cores) start(task, *cores);
    return cores.has_value();
  }

  void take(const std::vector<int>& cores) {
    for (const int core : cores) use_[index(core)] = Use::taken;
  }

  const Table& table_;
  const Resources& resources_;
  double time_left_;  ///< until the allocation's end [s]
  std::vector<Use> use_;
  std::vector<std::int64_t> memory_;  ///< free, by node [bytes]
  std::vector<bool> reserved_;        ///< by core: an earlier task waits for it
  std::set<TaskId> suspended_now_;
  std::vector<Decision> decisions_;
};

}  // namespace

std::vector<Decision> schedule(const Table& table, const Resources& resources, double time_left) {
  if (table.n_ready() == 0 && table.suspended.empty()) return {};
  return Scheduler(table, resources, time_left).decide();
}

}  // namespace granary::pilot
