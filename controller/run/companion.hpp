// Work beside the coupling, on the cores it leaves idle (an estimation). All calls come from the loop, after the
// journal has what they tell of; nothing of it may fail the campaign.
#pragma once

#include <functional>

#include "common/result.hpp"
#include "controller/coupling/event.hpp"
#include "controller/coupling/state.hpp"
#include "pilot/task/state.hpp"

namespace granary::run {

class Companion {
 public:
  virtual ~Companion() = default;

  /// The campaign begins, or goes on where the journal left it. Error: what the companion left behind is damaged.
  virtual Status begin(const coupling::State& state) = 0;
  /// An event has been decided and acted on; `state` is what it led to.
  virtual void told(const coupling::Event& event, const coupling::State& state) = 0;
  /// A task that is not the coupling's has ended.
  virtual void task_ended(const pilot::TaskEnd& end) = 0;
  /// The coupling is over (steady, or at a limit): ends its work, runs what is left to be run, and calls `done` (maybe
  /// at once). Also after a resume that finds the coupling over.
  virtual void finish(const coupling::State& state, std::function<void()> done) = 0;
};

}  // namespace granary::run
