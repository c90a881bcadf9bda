#include "pilot/schedule/machine.hpp"

#include <fmt/format.h>
#include <hwloc.h>
#include <sched.h>

#include <algorithm>
#include <memory>

#include "common/assert.hpp"

namespace granary::pilot {

int Machine::n_cores() const {
  int count = 0;
  for (const Node& node : nodes) count += static_cast<int>(node.cpus.size());
  return count;
}

int Machine::largest_node() const {
  int largest = 0;
  for (const Node& node : nodes) largest = std::max(largest, static_cast<int>(node.cpus.size()));
  return largest;
}

int Machine::node_of(int core) const {
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (core < static_cast<int>(nodes[k].cpus.size())) return static_cast<int>(k);
    core -= static_cast<int>(nodes[k].cpus.size());
  }
  GRANARY_ASSERT(false, core);
  return -1;
}

int Machine::cpu_of(int core) const {
  for (const Node& node : nodes) {
    if (core < static_cast<int>(node.cpus.size())) return node.cpus[static_cast<std::size_t>(core)];
    core -= static_cast<int>(node.cpus.size());
  }
  GRANARY_ASSERT(false, core);
  return -1;
}

namespace {

using Topology = std::unique_ptr<hwloc_topology, decltype(&hwloc_topology_destroy)>;

/// The first hardware thread that we may use of each core, in the order of the topology.
std::vector<int> allowed_cores(hwloc_topology_t topology) {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  const bool known = sched_getaffinity(0, sizeof allowed, &allowed) == 0;
  std::vector<int> cpus;
  hwloc_obj_t core = nullptr;
  while ((core = hwloc_get_next_obj_by_type(topology, HWLOC_OBJ_CORE, core)) != nullptr) {
    for (int cpu = hwloc_bitmap_first(core->cpuset); cpu >= 0; cpu = hwloc_bitmap_next(core->cpuset, cpu)) {
      if (known && (cpu >= CPU_SETSIZE || !CPU_ISSET(cpu, &allowed))) continue;
      cpus.push_back(cpu);
      break;
    }
  }
  if (!cpus.empty() || !known) return cpus;
  // Some containers show no cores: each hardware thread we may use is then taken for one.
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &allowed)) cpus.push_back(cpu);
  }
  return cpus;
}

}  // namespace

Result<Machine> local_machine(int cores) {
  hwloc_topology_t raw = nullptr;
  if (hwloc_topology_init(&raw) != 0) return Error{"hwloc cannot be started on this machine", Exit::internal};
  const Topology topology(raw, &hwloc_topology_destroy);
  if (hwloc_topology_load(raw) != 0) return Error{"hwloc cannot read this machine's topology", Exit::internal};

  Node node;
  node.name = "localhost";
  node.cpus = allowed_cores(raw);
  node.memory_bytes = static_cast<std::int64_t>(hwloc_get_root_obj(raw)->total_memory);
  const int found = static_cast<int>(node.cpus.size());
  if (found == 0) return Error{"no core of this machine may be used by this process"};
  if (cores > found) {
    return Error{
        fmt::format("{} cores were asked for, but this process may use {} physical core(s) of this machine; "
                    "ask for at most {} (hardware threads do not count)",
                    cores, found, found)};
  }
  if (cores > 0) node.cpus.resize(static_cast<std::size_t>(cores));
  return Machine{{std::move(node)}};
}

Machine stated_machine(int nodes, int cores_per_node, std::int64_t memory_bytes_per_node) {
  Machine machine;
  for (int n = 1; n <= nodes; ++n) {
    Node node;
    node.name = fmt::format("node{}", n);
    node.memory_bytes = memory_bytes_per_node;
    for (int k = 0; k < cores_per_node; ++k) node.cpus.push_back(k);
    machine.nodes.push_back(std::move(node));
  }
  return machine;
}

}  // namespace granary::pilot
