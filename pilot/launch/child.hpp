// What a new process does until it executes its program. Only for spawn.cpp and prepared_processes.cpp.
#pragma once

#include <sched.h>

#include <cstdint>
#include <vector>

#include "pilot/launch/spawn.hpp"

namespace granary::pilot {

enum class Stage { none, group, affinity, folder, output, files, execute };

/// All a child reads, and where it says what went wrong: it shares our memory until it executes the program, so this
/// must live until then.
struct Child {
  explicit Child(SpawnRequest request);

  SpawnRequest request;
  std::vector<char*> argv, env;
  cpu_set_t cpus = {};
  int spare_output = -1;  ///< an open file without a name, to become stdout_file; -1: none
  Stage failed = Stage::none;
  int code = 0;
};

// In the child, on a stack of its own but in our memory: system calls only.
void become_group_leader(Child* child);  ///< with the usual answer to every signal; child may be null
/// Comes back, with the exit code, only if something went wrong.
int execute(Child* child);

/// A file in this folder that has no name yet and goes with whoever has it open. -1: not in this file system.
int open_nameless(const std::string& folder);

Error spawn_error(const SpawnRequest& request, Stage stage, int code);
/// The clock of field 22 of /proc/PID/stat: time since boot in hundredths of a second, rounded down.
std::uint64_t boot_ticks();

}  // namespace granary::pilot
