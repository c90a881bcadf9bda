// The command line and environment a task is started with. Pure, except for looking an executable up.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "pilot/launch/launcher.hpp"
#include "pilot/schedule/machine.hpp"

namespace granary::pilot {

/// The file that would be executed: `command` itself if it has a '/' (a relative one from `dir`), else the first in
/// `path` (as in $PATH). Error: there is none, or it may not be executed; names the PATH searched.
Result<std::string> find_executable(const std::string& command, const std::filesystem::path& dir,
                                    std::string_view path);

/// Our environment plus OMP_NUM_THREADS, OMP_PLACES, OMP_PROC_BIND, GRANARY_MARK, GRANARY_TASK, GRANARY_ATTEMPT; the
/// task's own `env` has the last word. KEY=VALUE, each key once.
std::vector<std::string> environment_of(const Launch& launch, const std::vector<std::string>& ours);
/// The value of a variable in such a list; "" if it is not there.
std::string_view variable(const std::vector<std::string>& env, std::string_view key);

bool uses_mpirun(const TaskSpec& spec);
bool is_on_several_hosts(const Launch& launch);
/// What mpirun needs of Slurm's variables to reach the other hosts from inside a step.
void prepare_for_several_hosts(std::vector<std::string>& env);
/// `mpirun OPTIONS command...`, each rank pinned to cores of its own by the rank file.
std::vector<std::string> mpirun_argv(const Launch& launch, const std::vector<std::string>& env,
                                     const std::filesystem::path& rank_file, bool as_root);
/// Open MPI's rank file: rank k on the k-th group of `threads` cores (physical numbers).
std::string rank_file_text(const Launch& launch, const Machine& machine);

}  // namespace granary::pilot
