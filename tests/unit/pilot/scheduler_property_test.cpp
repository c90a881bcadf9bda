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
  explicit RandomPilot(Machine machine) : resources_(std::move(machine)) {}

  void submit() {
    TaskSpec spec = a_task("t" + std::to_string(table_.tasks.size()));
    spec.ranks = *rc::gen::inRange(1, resources_.machine().largest_node() + 1);
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
    std::vector<TaskId> active(table_.running.begin(), table_.running.end());
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
      for (const Decision& decision : schedule(table_, resources_))
        std::visit([this](const auto& d) { carry_out(d); }, decision);
    }
    RC_ASSERT(schedule(table_, resources_).empty());
    check_cores();
    check_no_ready_task_is_delayed_by_a_filler();
  }

 private:
  template <class What>
  void happens(What what) {
    time_ += 1.0;
    for (const Action& action : update(table_, Event{time_, std::move(what)})) {
      if (const auto* freed = std::get_if<FreeCores>(&action)) {
        resources_.release(freed->attempt.task, table_.at(freed->attempt.task).state == TaskState::suspended);
      }
    }
    const Status sound = table_.check_invariants();
    if (!sound) RC_FAIL(sound.error().message);
  }

  void take(TaskId id, const std::vector<int>& cores) {
    for (const int core : cores) RC_ASSERT(resources_.is_free(core));
    resources_.take(table_.at(id), cores);
  }
  void carry_out(const StartTask& d) {
    take(d.id, d.cores);
    happens(Placed{{d.id, table_.at(d.id).attempt_id().number + 1}, d.cores});
    RC_ASSERT(table_.at(d.id).state == TaskState::running);
  }
  void carry_out(const SuspendFiller& d) { happens(Suspended{table_.at(d.id).attempt_id()}); }
  void carry_out(const KillFiller& d) { happens(Preempted{table_.at(d.id).attempt_id()}); }
  void carry_out(const ResumeFiller& d) {
    take(d.id, d.cores);
    happens(Resumed{table_.at(d.id).attempt_id(), d.cores});
  }

  /// The book of cores says what the table says: so no core is held twice or by nobody.
  void check_cores() const {
    std::vector<TaskId> holder(static_cast<std::size_t>(resources_.n_cores()));
    for (const TaskId id : table_.running) {
      for (const int core : table_.at(id).last().pieces.back().cores) holder[static_cast<std::size_t>(core)] = id;
    }
    for (int core = 0; core < resources_.n_cores(); ++core) {
      RC_ASSERT(resources_.holder(core) == holder[static_cast<std::size_t>(core)]);
    }
  }

  /// The first ready task waits only for other tasks, or for fillers that are being killed for it: on no node would
  /// there be room for it without the fillers that go on running.
  void check_no_ready_task_is_delayed_by_a_filler() const {
    if (table_.ready.empty()) return;
    const Task& first = table_.at(table_.ready.begin()->id);
    bool killed_for_it = false, room_for_it = false;
    for (int node = 0; node < resources_.n_nodes(); ++node) {
      int leaving = 0, available = 0;
      for (int core = resources_.first_core(node); core < resources_.end_core(node); ++core) {
        const TaskId holder = resources_.holder(core);
        const bool filler = holder != TaskId{} && table_.at(holder).spec.fill;
        leaving += filler && table_.at(holder).ending == Ending::preempt;
        available += holder == TaskId{} || (filler && table_.at(holder).ending == Ending::none);
      }
      killed_for_it = killed_for_it || (leaving > 0 && leaving + available >= first.spec.cores());
      room_for_it = room_for_it || available >= first.spec.cores();
    }
    RC_ASSERT(killed_for_it || !room_for_it);
  }

  Table table_;
  Resources resources_;
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
