// Starts tasks as processes of this machine: argv as it is, never a shell; pinned to exactly their cores; several
// ranks through mpirun. The environment a task gets is told in docs/pilot.md.
#pragma once

#include <memory>
#include <string>

#include "pilot/launch/launcher.hpp"
#include "pilot/loop/real_loop.hpp"
#include "pilot/schedule/machine.hpp"

namespace granary::pilot {

class LocalLauncher final : public Launcher {
 public:
  /// `loop` must outlive the launcher.
  LocalLauncher(RealLoop& loop, Machine machine);
  ~LocalLauncher() override;  ///< kills what still runs

  Result<ProcessKey> start(const Launch& launch, std::function<void(const RunEnd&)> ended) override;
  void signal(AttemptId attempt, int signal_number) override;
  void kill(AttemptId attempt) override;
  void suspend(AttemptId attempt) override;
  void resume(AttemptId attempt, const CoreSet& cores) override;
  Status set_aside(const Launch& earlier, bool own_folder) override;
  bool end_orphan(const ProcessKey& key, const std::string& mark) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace granary::pilot
