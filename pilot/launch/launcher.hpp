// Starts, signals and ends the processes of a task: the one thing between the pilot's decisions and the world.
// local_launcher does it for real (argv or mpirun), simulated_launcher on a virtual clock.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "pilot/task/core_set.hpp"
#include "pilot/task/spec.hpp"

namespace granary::pilot {

/// A task's cores on one host. `cpus`: the operating system's numbers there.
struct HostCores {
  std::string host;
  std::vector<int> cpus;
};

/// All a launcher must know to start an attempt.
struct Launch {
  AttemptId attempt;
  TaskSpec spec;
  std::filesystem::path dir;     ///< absolute working folder
  CoreSet cores;                 ///< core indices of the machine; empty for a light task
  std::string mark;              ///< put into the environment (GRANARY_MARK), by which strays are found
  std::vector<HostCores> hosts;  ///< of a task over several nodes: all its cores, in the order of its ranks; else empty
};

/// What the system knows the first process by: enough to tell it from a later one with the same number.
struct ProcessKey {
  int pid = 0;
  std::uint64_t start_ticks = 0;  ///< field 22 of /proc/PID/stat
};

struct RunEnd {
  int exit_code = -1;                          ///< -1: ended by a signal
  int signal = 0;                              ///< 0: none
  double cpu_s = 0.0;                          ///< user and system time of all its processes that were waited for [s]
  std::vector<std::filesystem::path> missing;  ///< produces[] that do not exist; only looked for after exit code 0
  // Of a launcher that starts elsewhere; if one of them is there, nothing above counts:
  std::string not_started;  ///< why it could not be started: what start() would have said
  std::string lost;         ///< why nobody knows how it ended; none of its processes lives any more
};

/// Calls about an attempt that is not running (any more) do nothing.
class Launcher {
 public:
  virtual ~Launcher() = default;

  /// Starts the attempt; `ended` comes later from the event loop, exactly once, after all its processes are gone.
  /// Errors: no such executable (names it and the PATH searched), no folder, no output file; then `ended` never comes.
  virtual Result<ProcessKey> start(const Launch& launch, std::function<void(const RunEnd&)> ended) = 0;
  /// Asks the attempt's process group to end (mpirun passes SIGUSR1 on to its ranks); wakes it if it is suspended.
  virtual void signal(AttemptId attempt, int signal_number) = 0;
  /// Ends all processes of the attempt: SIGKILL to its process group, ranks and strays.
  virtual void kill(AttemptId attempt) = 0;
  virtual void suspend(AttemptId attempt) = 0;
  /// Goes on, on these cores (pinned anew if they are others than before).
  virtual void resume(AttemptId attempt, const CoreSet& cores) = 0;
  /// Before a retry: moves what the `earlier` attempt wrote into NAME.attempt-N/ beside it: its output files, what it
  /// should produce and, where the folder is the task's own, whatever was written there since it started.
  virtual Status set_aside(const Launch& earlier, bool own_folder) = 0;
  /// After a crash of the pilot: ends what still runs of an attempt. True if anything did.
  virtual bool end_orphan(const ProcessKey& key, const std::string& mark) = 0;
};

}  // namespace granary::pilot
