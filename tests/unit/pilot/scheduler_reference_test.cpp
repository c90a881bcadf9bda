// The scheduler held against a plain one that knows no index, on small machines and virtual time.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <map>
#include <set>

#include "pilot/schedule/scheduler.hpp"
#include "tests/unit/pilot/builders.hpp"

namespace granary::pilot::testing {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// What runs where, without any index: the plain scheduler's whole knowledge.
struct PlainMachine {
  std::vector<int> size, free;
  std::vector<std::int64_t> memory;

  /// Nodes for a task by trying all of them, fewest cores left first; empty: it does not fit.
  std::vector<std::pair<int, int>> fit(const Layout& layout, const std::vector<int>& usable) const {
    std::vector<std::pair<int, int>> parts;
    std::set<int> used;
    for (int k = 0; k < layout.nodes; ++k) {
      int best = -1;
      for (int node = 0; node < static_cast<int>(size.size()); ++node) {
        const auto n = static_cast<std::size_t>(node);
        if (used.count(node) != 0 || usable[n] < layout.cores_on(k) || memory[n] < layout.memory * layout.cores_on(k))
          continue;
        if (best < 0 || usable[n] < usable[static_cast<std::size_t>(best)]) best = node;
      }
      if (best < 0) return {};
      used.insert(best);
      parts.emplace_back(best, layout.cores_on(k));
    }
    return parts;
  }
};

struct Planned {
  TaskSpec spec;
  double seconds = 1.0;  ///< true running time, at most spec.duration() where that is known
  double submitted = 0.0;
};

std::vector<Planned> random_load(int n, int most_cores, bool memory) {
  std::vector<Planned> load;
  for (int k = 0; k < n; ++k) {
    Planned planned;
    planned.spec = a_task("t" + std::to_string(k));
    planned.spec.ranks = *rc::gen::inRange(1, most_cores + 1);
    planned.spec.priority = *rc::gen::weightedElement<int>({{6, 0}, {1, 1}, {1, -1}});
    planned.seconds = *rc::gen::inRange(1, 30);
    if (*rc::gen::inRange(0, 4) != 0) planned.spec.expected = planned.seconds + *rc::gen::inRange(0, 20);
    if (memory && *rc::gen::inRange(0, 2) == 0)
      planned.spec.memory_bytes = planned.spec.ranks * *rc::gen::inRange(1, 4);
    planned.submitted = *rc::gen::inRange(0, 40);
    load.push_back(std::move(planned));
  }
  return load;
}

/// Runs a load on the scheduler, checking after every round what must hold at any time.
class Course {
 public:
  Course(Machine machine, std::vector<Planned> load) : load_(std::move(load)), scheduler_(table_, std::move(machine)) {}

  void run() {
    std::multimap<double, int> arrivals;
    for (std::size_t k = 0; k < load_.size(); ++k) arrivals.emplace(load_[k].submitted, static_cast<int>(k));
    while (!arrivals.empty() || !ends_.empty()) {
      now_ = kNever;
      if (!arrivals.empty()) now_ = arrivals.begin()->first;
      if (!ends_.empty()) now_ = std::min(now_, ends_.begin()->first);
      for (; !ends_.empty() && ends_.begin()->first <= now_; ends_.erase(ends_.begin())) {
        const TaskId id = ends_.begin()->second;
        happens(Exited{table_.at(id).attempt_id(), 0, 0, 0.0, {}});
      }
      for (; !arrivals.empty() && arrivals.begin()->first <= now_; arrivals.erase(arrivals.begin())) {
        const TaskId id{static_cast<int>(table_.tasks.size())};
        planned_.push_back(arrivals.begin()->second);
        happens(Submitted{id, load_[static_cast<std::size_t>(arrivals.begin()->second)].spec});
      }
      round();
    }
    for (const Task& task : table_.tasks) RC_ASSERT(task.state == TaskState::finished);  // nothing starves
  }

 private:
  template <class What>
  void happens(What what) {
    (void)update(table_, Event{now_, std::move(what)});
    const Status sound = table_.check_invariants();  // among others: no core is held twice
    if (!sound) RC_FAIL(sound.error().message);
  }

  const Planned& planned(TaskId id) const {
    return load_[static_cast<std::size_t>(planned_[static_cast<std::size_t>(id.value)])];
  }

  Turn turn_of(TaskId id) const { return {table_.at(id).spec.priority, id}; }

  void round() {
    for (const Decision& decision : scheduler_.decide(now_)) {
      const auto& start = std::get<StartTask>(decision);
      check_turn(start.id);
      // A promise is to the first in turn; one of higher priority may push it back.
      if (promise_task_ != TaskId{} && turn_of(start.id) < turn_of(promise_task_)) promise_task_ = TaskId{};
      happens(Placed{{start.id, 1}, start.cores});
      ends_.emplace(now_ + planned(start.id).seconds, start.id);
      if (promise_task_ == start.id) {
        RC_ASSERT(now_ <= promise_ + 1e-9);  // a reservation is never delayed
        promise_task_ = TaskId{};
      }
    }
    RC_ASSERT(scheduler_.decide(now_).empty());
    check_memory();
    check_first_cannot_start();
    const auto& reservation = scheduler_.reservation();
    if (!reservation) {
      promise_task_ = TaskId{};
    } else if (promise_task_ != reservation->task) {
      promise_task_ = reservation->task;
      promise_ = reservation->start;
    } else {
      promise_ = std::min(promise_, reservation->start);
    }
  }

  std::optional<TaskId> first_ready() const {
    std::optional<TaskId> first;
    for (const Task& task : table_.tasks) {
      if (task.state == TaskState::ready && (!first || task.spec.priority > table_.at(*first).spec.priority))
        first = task.id;
    }
    return first;
  }

  PlainMachine plain() const {
    const Resources& resources = scheduler_.resources();
    PlainMachine machine;
    for (int node = 0; node < resources.n_nodes(); ++node) {
      machine.size.push_back(resources.end_core(node) - resources.first_core(node));
      machine.free.push_back(machine.size.back());
      machine.memory.push_back(resources.machine().nodes[static_cast<std::size_t>(node)].memory_bytes);
    }
    for (const TaskId id : table_.running()) {
      const TaskSpec& spec = table_.at(id).spec;
      table_.at(id).last().pieces.back().cores.for_each([&](int core) {
        const auto node = static_cast<std::size_t>(resources.node_of(core));
        --machine.free[node];
        machine.memory[node] -= spec.memory_bytes / spec.cores();
      });
    }
    return machine;
  }

  /// A task that goes before its turn must not have taken what an earlier one of its very needs could have used.
  void check_turn(TaskId id) const {
    const Task& task = table_.at(id);
    const Layout layout = scheduler_.layouts().of(task.spec);
    for (const Task& other : table_.tasks) {
      if (other.state != TaskState::ready || other.id == id) continue;
      const bool earlier = Turn{other.spec.priority, other.id} < Turn{task.spec.priority, task.id};
      if (!earlier || scheduler_.layouts().of(other.spec) != layout) continue;
      // The same needs: only a task known to be short may go first, into a reservation's cores. (Durations are sorted
      // by powers of 2, so one above half the time left may count as too long.)
      RC_ASSERT(scheduler_.reservation() && task.spec.duration() > 0.0 &&
                (other.spec.duration() == 0.0 || 2.0 * other.spec.duration() > scheduler_.reservation()->start - now_ ||
                 scheduler_.reservation()->task == other.id));
    }
  }

  void check_memory() const {
    for (const std::int64_t memory : plain().memory) RC_ASSERT(memory >= 0);
  }

  /// The plain scheduler finds no room for the first task in turn either.
  void check_first_cannot_start() const {
    const auto first = first_ready();
    if (!first) return;
    const PlainMachine machine = plain();
    RC_ASSERT(machine.fit(scheduler_.layouts().of(table_.at(*first).spec), machine.free).empty());
  }

  std::vector<Planned> load_;
  std::vector<int> planned_;  ///< by task id: which of the load
  Table table_;
  Scheduler scheduler_;
  std::multimap<double, TaskId> ends_;
  TaskId promise_task_;
  double promise_ = kNever, now_ = 0.0;
};

Machine random_machine(bool memory) {
  Machine machine;
  const int nodes = *rc::gen::inRange(1, 5);
  for (int node = 0; node < nodes; ++node) {
    Machine one = stated_machine(1, *rc::gen::inRange(1, 6), memory ? 15 : 0);
    machine.nodes.push_back(one.nodes.front());
  }
  return machine;
}

RC_GTEST_PROP(SchedulerReference, StartsTheFirstWhenItFitsAndKeepsEveryPromise, ()) {
  const Machine machine = random_machine(false);
  Course(machine, random_load(*rc::gen::inRange(1, 40), machine.largest_node(), false)).run();
}

RC_GTEST_PROP(SchedulerReference, KeepsEveryPromiseOnEqualNodesWithTasksOverSeveral, ()) {
  const int nodes = *rc::gen::inRange(1, 5), cores = *rc::gen::inRange(1, 5);
  const Machine machine = stated_machine(nodes, cores);
  Course(machine, random_load(*rc::gen::inRange(1, 40), nodes * cores, false)).run();
}

RC_GTEST_PROP(SchedulerReference, KeepsMemoryWithinBoundsAndStarvesNobody, ()) {
  const Machine machine = random_machine(true);
  Course(machine, random_load(*rc::gen::inRange(1, 40), machine.largest_node(), true)).run();
}

}  // namespace
}  // namespace granary::pilot::testing
