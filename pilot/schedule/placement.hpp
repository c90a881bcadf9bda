// How many cores of how many nodes a task needs, and which ones it gets. Pure.
#pragma once

#include <optional>
#include <vector>

#include "common/result.hpp"
#include "pilot/schedule/resources.hpp"

namespace granary::pilot {

/// A core, as the scheduler sees it while it decides: idle; given up by a filler that is being killed; a filler's, who
/// would give it up; not to be had.
enum class Use : char { free, leaving, filler, taken };

/// What a task may have, in the middle of a round of decisions.
struct Availability {
  std::vector<Use> use;                   ///< by core
  std::vector<std::int64_t> free_memory;  ///< by node [bytes]
};

/// Cores on each of the nodes that the ranks are spread over, largest first: 5 ranks x 2 threads on 2 nodes: {6, 4}.
std::vector<int> cores_by_node(const TaskSpec& spec, int nodes);
/// How many nodes at least the machine needs for the task; 0: it does not fit, however empty the machine is.
int fewest_nodes(const TaskSpec& spec, const Machine& machine);

/// The cores the task would get: on the node that fits tightest, near each other, idle ones first, fillers' last.
/// Nothing if there are not enough of them, or not enough memory.
std::optional<std::vector<int>> choose_cores(const TaskSpec& spec, const Resources& resources,
                                             const Availability& available);
/// Books the memory of a task that gets these cores.
void take_memory(const TaskSpec& spec, const std::vector<int>& cores, const Resources& resources,
                 Availability& available);

/// The cores a task that cannot start yet should wait for: where most are free already. Of those, the free ones and
/// enough others; cores in `reserved` are not for it. By core.
std::vector<int> cores_to_wait_for(const TaskSpec& spec, const Resources& resources, const std::vector<Use>& use,
                                   const std::vector<bool>& reserved);

}  // namespace granary::pilot
