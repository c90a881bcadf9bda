// Rules that hold whatever happens, in whatever order.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "pilot/schedule/scheduler.hpp"
#include "tests/unit/pilot/builders.hpp"

namespace granary::pilot::testing {
namespace {

/// A pilot without journal and processes, driven by random choices.
class RandomPilot {
 public:
  explicit RandomPilot(Machine machine) : scheduler_(table_, std::move(machine)) {}

  void submit() {
    TaskSpec spec = a_task("t" + std::to_string(table_.tasks.size()));
    spec.ranks = *rc::gen::inRange(1, resources().machine().largest_node() + 1);
    spec.fill = *rc::gen::arbitrary<bool>();
    spec.preempt = *rc::gen::arbitrary<bool>() ? Preempt::suspend : Preempt::kill;
    spec.light = !spec.fill && spec.ranks == 1 && *rc::gen::inRange(0, 5) == 0;
    spec.priority = *rc::gen::inRange(-1, 2);
    spec.retries = *rc::gen::inRange(0, 2);
    if (!table_.tasks.empty() && *rc::gen::inRange(0, 4) == 0) {
      spec.after.push_back(table_.tasks[*rc::gen::inRange<std::size_t>(0, table_.tasks.size())].spec.name);
    }
    happens(Submitted{TaskId{static_cast<int>(table_.tasks.size())}, spec});
  }

  /// Something happens to one of the tasks that run or are suspended.
  void disturb() {
    std::vector<TaskId> active = table_.running();
    for (const Turn& turn : table_.suspended) active.push_back(turn.id);
    if (active.empty()) return;
    const TaskId id = active[*rc::gen::inRange<std::size_t>(0, active.size())];
    const AttemptId attempt = table_.at(id).attempt_id();
    switch (*rc::gen::inRange(0, 6)) {
      case 0:
        return happens(Exited{attempt, 1, 0, 0.0, {}});
      case 1:
        return happens(StopAsked{id, "why not", *rc::gen::arbitrary<bool>()});
      case 2:
        return happens(TimedOut{attempt});
      case 3:
        return happens(Lost{attempt, "power cut"});
      default:
        return happens(Exited{attempt, 0, 0, 0.0, {}});
    }
  }

  void decide() {
    // A filler that gave way may go on on other cores in the second round; then all is decided.
    for (int round = 0; round < 2; ++round) {
      for (const Decision& decision : scheduler_.decide(time_))
        std::visit([this](const auto& d) { carry_out(d); }, decision);
    }
    RC_ASSERT(scheduler_.decide(time_).empty());
    check_cores();
    check_no_ready_task_is_delayed_by_a_filler();
  }

 private:
  template <class What>
  void happens(What what) {
    time_ += 1.0;
    (void)update(table_, Event{time_, std::move(what)});
    const Status sound = table_.check_invariants();
    if (!sound) RC_FAIL(sound.error().message);
  }

  void carry_out(const StartTask& d) {
    happens(Placed{{d.id, table_.at(d.id).attempt_id().number + 1}, d.cores});
    RC_ASSERT(table_.at(d.id).state == TaskState::running);
  }
  void carry_out(const SuspendFiller& d) { happens(Suspended{table_.at(d.id).attempt_id()}); }
  void carry_out(const KillFiller& d) { happens(Preempted{table_.at(d.id).attempt_id()}); }
  void carry_out(const ResumeFiller& d) { happens(Resumed{table_.at(d.id).attempt_id(), d.cores}); }

  const Resources& resources() const { return scheduler_.resources(); }

  /// The book of cores says what the table says: so no core is held twice or by nobody.
  void check_cores() const {
    std::vector<TaskId> holder(static_cast<std::size_t>(resources().n_cores()));
    for (const TaskId id : table_.running()) {
      for (const int core : table_.at(id).last().pieces.back().cores.list())
        holder[static_cast<std::size_t>(core)] = id;
    }
    for (int core = 0; core < resources().n_cores(); ++core) {
      RC_ASSERT(resources().holder(core) == holder[static_cast<std::size_t>(core)]);
    }
  }

  /// The first ready task that has no cores coming to it waits only for other tasks: on no node would there be room for
  /// it if the fillers gave way.
  void check_no_ready_task_is_delayed_by_a_filler() const {
    const Task* first = nullptr;
    for (const Task& task : table_.tasks) {
      if (task.state != TaskState::ready || task.spec.fill || task.spec.light) continue;
      if (scheduler_.waits_for_fillers(task.id)) continue;
      if (first == nullptr || task.spec.priority > first->spec.priority) first = &task;
    }
    if (first == nullptr) return;
    for (int node = 0; node < resources().n_nodes(); ++node) {
      int available = 0;
      for (int core = resources().first_core(node); core < resources().end_core(node); ++core) {
        const TaskId holder = resources().holder(core);
        const bool lent = holder != TaskId{} && table_.at(holder).spec.fill && table_.at(holder).ending == Ending::none;
        available += (holder == TaskId{} || lent) && !resources().is_claimed(core);
      }
      RC_ASSERT(available < first->spec.cores());
    }
  }

  Table table_;
  Scheduler scheduler_;
  double time_ = 0.0;
};

RC_GTEST_PROP(SchedulerProperty, NeverBooksACoreTwiceAndNeverDelaysAReadyTaskForAFiller, ()) {
  RandomPilot pilot(stated_machine(*rc::gen::inRange(1, 4), *rc::gen::inRange(1, 6)));
  const int steps = *rc::gen::inRange(1, 60);
  for (int step = 0; step < steps; ++step) {
    if (*rc::gen::arbitrary<bool>()) {
      pilot.submit();
    } else {
      pilot.disturb();
    }
    pilot.decide();
  }
}

}  // namespace
}  // namespace granary::pilot::testing
