// What a user or the controller asks the pilot to run: plain data, SI, all defaults filled in.
// Reading it from a workflow is task/spec_json; what happens to it is task/table and task/update.
#pragma once

#include <bitset>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace granary::pilot {

/// A task's number in its campaign, in order of submission, from 0.
struct TaskId {
  int value = -1;
  auto operator<=>(const TaskId&) const = default;  // NOLINT(modernize-use-nullptr): clang-tidy 14 mistakes <=>
};

/// One try to run a task; never used twice.
struct AttemptId {
  TaskId task;
  int number = 0;                                      ///< from 1
  auto operator<=>(const AttemptId&) const = default;  // NOLINT(modernize-use-nullptr): likewise
};

/// What is done to a filler whose cores a ready task needs.
enum class Preempt : char { suspend, kill };

/// Where a task goes when several nodes have room: on the one that fits most tightly, or on the emptiest.
enum class Placement : char { pack, spread };

/// How a task is asked to end: its signal, then `grace` seconds, then SIGKILL to all its processes.
struct StopRule {
  std::optional<int> signal;  ///< none: SIGUSR1 with several ranks (mpirun forwards it), else SIGTERM
  double grace = 10.0;        ///< [s] > 0
  bool operator==(const StopRule&) const = default;
};

using ExitCodes = std::bitset<256>;

/// What the scheduler asks for comes before what is only there for the start.
struct TaskSpec {
  std::string name;                  ///< letters, digits, '.', '_', '-'; no two tasks of a campaign share it
  std::vector<std::string> command;  ///< argv, never a shell line; command[0] is looked up in PATH unless it has a '/'
  int ranks = 1;                     ///< MPI processes; more than 1 are started with mpirun
  int threads = 1;                   ///< cores of each rank (OMP_NUM_THREADS)
  int nodes = 0;                     ///< nodes to spread the ranks over evenly; 0: as few as possible
  int priority = 0;                  ///< larger goes first; equal ones in order of submission
  int retries = 0;                   ///< further attempts after a failed one
  Placement placement = Placement::pack;
  bool mpi = false;                    ///< start with mpirun even with one rank
  bool light = false;                  ///< next to no CPU (a monitor): occupies no core, starts as soon as it is ready
  bool fill = false;                   ///< runs only on idle cores, gives way at once
  Preempt preempt = Preempt::suspend;  ///< fillers only
  bool resumable = false;         ///< stopped by its signal, a next attempt goes on where it was: may meet the deadline
  std::int64_t memory_bytes = 0;  ///< of the whole task; 0: not counted
  double timeout = 0.0;           ///< [s] running time of one attempt after which it is stopped and has failed; 0: none
  double expected = 0.0;  ///< [s] running time it will hardly exceed, for planning; 0: its timeout, else unknown
  ExitCodes success{1};   ///< exit codes of an attempt that has done its work: a monitor's verdicts are such
  StopRule stop;
  std::vector<std::string> after;                        ///< names of tasks that must have finished first
  std::vector<std::pair<std::string, std::string>> env;  ///< added to the pilot's own environment
  std::filesystem::path dir;  ///< working folder, made if missing; relative to (and by default) the pilot's folder
  std::vector<std::filesystem::path>
      produces;                       ///< must exist after exit code 0, else the task has failed; relative to dir
  std::filesystem::path stdout_file;  ///< relative to dir; default NAME.out
  std::filesystem::path stderr_file;  ///< relative to dir; default: the same file as stdout

  /// Running time to plan with [s]; 0: unknown.
  double duration() const { return expected > 0.0 ? expected : timeout; }
  int cores() const { return light ? 0 : ranks * threads; }
  bool operator==(const TaskSpec&) const = default;
};

/// The signal that asks this task to end.
int stop_signal(const TaskSpec& spec);

}  // namespace granary::pilot
