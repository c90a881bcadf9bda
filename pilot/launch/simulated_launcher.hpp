// Starts nothing: tasks take the time a cost model says, on any event loop. The dry run and the tests use it.
#pragma once

#include <boost/unordered/unordered_flat_map.hpp>
#include <functional>
#include <vector>

#include "pilot/launch/launcher.hpp"
#include "pilot/loop/event_loop.hpp"

namespace granary::pilot {

/// What a task would do.
struct SimulatedRun {
  double seconds = 0.0;  ///< running time (not counting suspension) until it ends by itself
  int exit_code = 0;
  double stop_after = 0.0;       ///< [s] from its stop signal to its end
  int stop_exit_code = 0;        ///< exit code after its stop signal
  bool ignores_stop = false;     ///< only SIGKILL ends it early
  std::function<void()> at_end;  ///< called just before its end is reported, however it ends (may be empty)
};

class SimulatedLauncher final : public Launcher {
 public:
  SimulatedLauncher(EventLoop& loop, std::function<SimulatedRun(const TaskSpec&)> model);

  Result<ProcessKey> start(const Launch& launch, std::function<void(const RunEnd&)> ended) override;
  void signal(AttemptId attempt, int signal_number) override;
  void kill(AttemptId attempt) override;
  void suspend(AttemptId attempt) override;
  void resume(AttemptId attempt, const CoreSet& cores) override;
  Status set_aside(const Launch& earlier, bool own_folder) override;
  bool end_orphan(const ProcessKey& key, const std::string& mark) override;

 private:
  struct Run {
    AttemptId attempt;
    SimulatedRun plan;
    int cores = 0;
    double left = 0.0;   ///< running time still to come [s]
    double since = 0.0;  ///< clock when `left` was last true [s]
    double cpu_s = 0.0;
    bool suspended = false;
    int exit_code = 0, signal = 0;  ///< what it will end with
    TimerId timer = TimerId::none;
    std::function<void(const RunEnd&)> ended;
  };
  Run* find(AttemptId attempt);
  void settle(Run& run);
  void arm(Run& run);
  void end(std::size_t place);

  EventLoop& loop_;
  std::function<SimulatedRun(const TaskSpec&)> model_;
  struct Hash {
    std::size_t operator()(AttemptId id) const {
      return static_cast<std::size_t>(id.task.value) * 31U + static_cast<std::size_t>(id.number);
    }
  };
  std::vector<Run> runs_;  ///< in no order
  std::vector<std::size_t> free_places_;
  boost::unordered_flat_map<AttemptId, std::size_t, Hash> place_of_;
};

}  // namespace granary::pilot
