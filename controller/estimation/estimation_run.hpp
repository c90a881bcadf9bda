// An estimation by itself: a pilot whose only tasks are the crew's. Behind `granary estimate` and its bench.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "controller/estimation/crew.hpp"
#include "pilot/pilot.hpp"

namespace granary::estimating {

class EstimationRun {
 public:
  /// All must outlive it; takes the pilot's on_end and on_idle. `changed` is called after each task that has ended.
  EstimationRun(
      Crew& crew, pilot::Pilot& pilot, pilot::EventLoop& loop, std::function<void()> changed = [] {});

  /// Submits the first tasks. The crew has begun. The loop then drives everything, and is stopped at the end.
  Status begin();
  /// Why it could not go on.
  const std::optional<Error>& failure() const { return failure_; }

 private:
  void submit();
  void task_ended(const pilot::TaskEnd& end);
  void fail(const Error& error);

  Crew& crew_;
  pilot::Pilot& pilot_;
  pilot::EventLoop& loop_;
  std::function<void()> changed_;
  std::optional<Error> failure_;
};

}  // namespace granary::estimating
