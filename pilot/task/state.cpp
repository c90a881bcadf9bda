#include "pilot/task/state.hpp"

#include <csignal>

namespace granary::pilot {

std::string_view name_of(TaskState state) {
  switch (state) {
    case TaskState::waiting:
      return "waiting";
    case TaskState::ready:
      return "ready";
    case TaskState::running:
      return "running";
    case TaskState::suspended:
      return "suspended";
    case TaskState::finished:
      return "finished";
    case TaskState::failed:
      return "failed";
    case TaskState::stopped:
      return "stopped";
    case TaskState::lost:
      return "lost";
  }
  return "";
}

int stop_signal(const TaskSpec& spec) {
  // mpirun passes SIGUSR1 on to its ranks and lets them end; on SIGTERM it kills them a second later.
  return spec.stop.signal.value_or(spec.ranks > 1 || spec.mpi ? SIGUSR1 : SIGTERM);
}

}  // namespace granary::pilot
