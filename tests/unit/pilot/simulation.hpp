// The whole pilot on virtual time: the same scheduler and life cycle as for real, without a process.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pilot/launch/simulated_launcher.hpp"
#include "pilot/loop/virtual_loop.hpp"
#include "pilot/pilot.hpp"
#include "tests/unit/pilot/builders.hpp"

namespace granary::pilot::testing {

/// A simulated site; a task's running time is asked of `model`, 10 s by default.
struct Simulation {
  /// `past`: what an earlier pilot has left in the journal.
  explicit Simulation(Machine m, const std::vector<Record>& past = {})
      : journal(with(past)),
        machine(std::move(m)),
        opened(Pilot::open({"/campaign", machine}, loop, launcher, journal)),
        pilot(**opened) {
    pilot.on_end([this](const TaskEnd& end) { ended.push_back(end.name); });
  }
  VirtualLoop loop;
  std::function<SimulatedRun(const TaskSpec&)> model = [](const TaskSpec&) { return SimulatedRun{10.0}; };
  SimulatedLauncher launcher{loop, [this](const TaskSpec& spec) { return model(spec); }};
  Journal journal;
  Machine machine;
  Result<std::unique_ptr<Pilot>> opened;
  Pilot& pilot;
  std::vector<std::string> ended;

  Journal with(const std::vector<Record>& past) {
    Journal memory = Journal::in_memory([this] { return loop.wall_time(); });
    for (const Record& record : past) EXPECT_TRUE(memory.append(record.kind, record.payload).has_value());
    return memory;
  }
  TaskId submit(const TaskSpec& spec) {
    const auto id = pilot.submit(spec);
    EXPECT_TRUE(id.has_value()) << id.error().message;
    return *id;
  }
};

}  // namespace granary::pilot::testing
