// Tasks and tables for the pilot's tests: what a case is not about has a default.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pilot/task/update.hpp"

namespace granary::pilot::testing {

struct a_task {
  TaskSpec spec;
  explicit a_task(std::string name) {
    spec.name = std::move(name);
    spec.command = {"run", spec.name};
  }
  a_task& needs(int ranks, int threads = 1) { return spec.ranks = ranks, spec.threads = threads, *this; }
  a_task& after(std::vector<std::string> names) { return spec.after = std::move(names), *this; }
  a_task& priority(int value) { return spec.priority = value, *this; }
  a_task& fills(Preempt preempt = Preempt::suspend) { return spec.fill = true, spec.preempt = preempt, *this; }
  a_task& light() { return spec.light = true, *this; }
  a_task& retries(int count) { return spec.retries = count, *this; }
  a_task& timeout(double seconds) { return spec.timeout = seconds, *this; }
  a_task& memory(std::int64_t bytes) { return spec.memory_bytes = bytes, *this; }
  a_task& nodes(int count) { return spec.nodes = count, *this; }
  operator TaskSpec() const { return spec; }  // NOLINT: reads well in the tests
};

/// A table and the events that happen to it, one second after the other.
class Life {
 public:
  Table table;
  double time = 0.0;

  template <class What>
  std::vector<Action> happens(What what) {
    time += 1.0;
    std::vector<Action> actions = update(table, Event{time, std::move(what)});
    const Status sound = table.check_invariants();
    EXPECT_TRUE(sound.has_value()) << sound.error().message;
    return actions;
  }
  TaskId submit(const TaskSpec& spec) {
    const TaskId id{static_cast<int>(table.tasks.size())};
    happens(Submitted{id, spec});
    return id;
  }
  std::vector<Action> place(TaskId id, std::vector<int> cores) {
    return happens(Placed{{id, table.at(id).attempt_id().number + 1}, std::move(cores)});
  }
  std::vector<Action> exit(TaskId id, int code = 0) { return happens(Exited{attempt(id), code, 0, 0.5, {}}); }
  AttemptId attempt(TaskId id) const { return table.at(id).attempt_id(); }
  TaskState state(TaskId id) const { return table.at(id).state; }
  const std::string& reason(TaskId id) const { return table.at(id).reason; }
};

template <class What>
const What* find_action(const std::vector<Action>& actions) {
  for (const Action& action : actions) {
    if (const auto* found = std::get_if<What>(&action)) return found;
  }
  return nullptr;
}

}  // namespace granary::pilot::testing
