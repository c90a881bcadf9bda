// The cores we may use, by node: found with hwloc on this machine, or stated for a dry run.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::pilot {

/// One node. `cpus[k]` is the operating system's number of the first hardware thread of its k-th core.
struct Node {
  std::string name;
  std::vector<int> cpus;
  std::int64_t memory_bytes = 0;  ///< 0: unknown, not counted
};

/// Cores are numbered through all nodes: 0 .. n_cores()-1, neighbours near each other.
struct Machine {
  std::vector<Node> nodes;

  int n_cores() const;
  int largest_node() const;     ///< cores of the largest node
  int node_of(int core) const;  ///< index into nodes
  int cpu_of(int core) const;   ///< the operating system's number of that core on its node
};

/// This machine: physical cores (not hardware threads) that this process is allowed to run on, in the order of the
/// topology. `cores` > 0 takes only that many. Error: fewer cores than that are there (says how many).
Result<Machine> local_machine(int cores = 0);

/// A stated machine of equal nodes named node1, node2, ...
Machine stated_machine(int nodes, int cores_per_node, std::int64_t memory_bytes_per_node = 0);

}  // namespace granary::pilot
