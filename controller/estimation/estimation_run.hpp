// An estimation by itself: a pilot whose only tasks are the crew's, and what runs once with the result. Behind `granary
// estimate` and its bench.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "controller/estimation/crew.hpp"
#include "pilot/pilot.hpp"

namespace granary::estimating {

class EstimationRun {
 public:
  using Tasks = std::vector<pilot::TaskSpec>;
  /// All must outlive it; takes the pilot's on_end and on_idle. `changed` is called after each task that has ended,
  /// `last` once everything is known: it makes the tasks that are still to be run, under names that are always the
  /// same.
  EstimationRun(
      Crew& crew, pilot::Pilot& pilot, pilot::EventLoop& loop, std::function<void()> changed = [] {},
      std::function<Result<Tasks>()> last = [] { return Tasks(); });

  /// Submits the first tasks. The crew has begun. The loop then drives everything, and is stopped at the end.
  Status begin();
  /// Everything is known, and the last tasks have run.
  bool complete() const { return ending_ && last_names_.empty() && !failure_; }
  /// Why it could not go on.
  const std::optional<Error>& failure() const { return failure_; }

 private:
  void submit();
  void end();
  void task_ended(const pilot::TaskEnd& end);
  void fail(const Error& error);

  Crew& crew_;
  pilot::Pilot& pilot_;
  pilot::EventLoop& loop_;
  std::function<void()> changed_;
  std::function<Result<Tasks>()> last_;
  bool ending_ = false;
  std::set<std::string> last_names_;  ///< that have not ended
  std::optional<Error> failure_;
};

}  // namespace granary::estimating
