// Processes that are made before there is anything to run: each waits, in a group of its own, for the program it is to
// execute. Making one takes a third of a start, and a new process has to queue for its core behind whatever runs there,
// while one that wakes up goes first. Where tasks write into the same folder one after the other, each has the file for
// the next output open already, without a name: it is gone with the process if nobody needs it.
#pragma once

#include <memory>
#include <optional>

#include "pilot/launch/spawn.hpp"

namespace granary::pilot {

class PreparedProcesses {
 public:
  /// Keeps so many ready, each made anew by a thread of its own once the one before has executed its program.
  explicit PreparedProcesses(int count);
  ~PreparedProcesses();
  PreparedProcesses(const PreparedProcesses&) = delete;
  PreparedProcesses& operator=(const PreparedProcesses&) = delete;

  /// Lets one go, and does not wait for it: whether it could start is told by start_failure() when it has ended.
  /// Nothing: none is ready just now. The request must name files, not descriptors.
  std::optional<Spawned> start(const SpawnRequest& request);

 private:
  struct Slot;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace granary::pilot
