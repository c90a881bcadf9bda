// How many cores of how many nodes a task needs, and which ones it gets. Pure.
#pragma once

#include <optional>
#include <vector>

#include "common/result.hpp"
#include "pilot/schedule/resources.hpp"

namespace granary::pilot {

/// Cores that a task could have, as the scheduler sees them while it decides.
enum class Use : char { free, filler, taken };

/// Cores on each of the nodes that the ranks are spread over, largest first: 5 ranks x 2 threads on 2 nodes: {6, 4}.
std::vector<int> cores_by_node(const TaskSpec& spec, int nodes);
/// How many nodes at least the machine needs for the task; 0: it does not fit, however empty the machine is.
int fewest_nodes(const TaskSpec& spec, const Machine& machine);

/// The cores the task would get: on the node that fits tightest, near each other, free ones before a filler's. Nothing if
/// there are not enough of them, or not enough memory. `use` by core.
std::optional<std::vector<int>> choose_cores(const TaskSpec& spec, const Resources& resources, const std::vector<Use>& use);

/// The cores a task that cannot start yet should wait for: where most are free already. Of those, the free ones and enough
/// others; cores in `reserved` are not for it. By core.
std::vector<int> cores_to_wait_for(const TaskSpec& spec, const Resources& resources, const std::vector<Use>& use,
                                   const std::vector<bool>& reserved);

}  // namespace granary::pilot
