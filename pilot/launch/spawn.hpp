// One process from one argv: the system calls, nothing else. Everything a task needs (pinning, group, folder, files)
// is set in the child before it executes the program.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::pilot {

struct SpawnRequest {
  std::string file;  ///< the executable; a relative one is taken from `dir`
  std::vector<std::string> argv;
  std::vector<std::string> env;  ///< KEY=VALUE, all of it
  std::string dir;               ///< working folder; empty: ours
  std::vector<int> cpus;         ///< the operating system's CPU numbers to run on; empty: ours
  bool background = false;       ///< at our priority lowered by 19 (nice): whatever else wants its CPUs goes first
  int stdin_fd = -1;             ///< -1: /dev/null
  int stdout_fd = -1;            ///< -1: /dev/null, as for stderr
  int stderr_fd = -1;
  std::string stdout_file;  ///< made anew by the process, with its absolute path; empty: stdout_fd. Likewise for stderr
  std::string stderr_file;  ///< the same as stdout_file: one file for both
};

struct Child;

struct Spawned {
  int pid = 0;
  int pidfd = -1;                 ///< readable when it has ended; the caller closes it
  std::uint64_t start_ticks = 0;  ///< as start_ticks(pid), but for free
  /// Of a process that was prepared: keep it until it has ended. Only then it is known whether it could start.
  std::shared_ptr<Child> child;
};

/// Why a prepared process could not execute its program; asked for when it has ended.
std::optional<Error> start_failure(const std::shared_ptr<Child>& child);

/// How a process ended, and what it cost.
struct ProcessEnd {
  int exit_code = -1;  ///< -1: ended by a signal
  int signal = 0;
  double cpu_s = 0.0;  ///< of it and the children it waited for [s]
};

/// Starts a process that leads a process group of its own, waiting until it executes its program. The cost does not
/// grow with our own memory (vfork semantics), and a failure of execve comes back here, not as an exit code.
Result<Spawned> spawn(const SpawnRequest& request);

/// Takes the end of a process whose pidfd is readable (waits for it if not).
ProcessEnd reap(int pidfd);

/// Field 22 of /proc/PID/stat: with the pid, it tells a process from a later one of the same number. 0: no such
/// process.
std::uint64_t start_ticks(int pid);

}  // namespace granary::pilot
