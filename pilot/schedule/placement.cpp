#include "pilot/schedule/placement.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace granary::pilot {
namespace {

/// `count` of the sorted `cores` that span the shortest stretch.
std::vector<int> nearest(const std::vector<int>& cores, std::size_t count) {
  if (count == 0) return {};
  std::size_t best = 0;
  for (std::size_t k = 1; k + count <= cores.size(); ++k) {
    if (cores[k + count - 1] - cores[k] < cores[best + count - 1] - cores[best]) best = k;
  }
  const auto begin = cores.begin() + static_cast<std::ptrdiff_t>(best);
  return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

std::vector<int> cores_of_use(const Resources& resources, int node, const std::vector<Use>& use, Use wanted) {
  std::vector<int> cores;
  for (int core = resources.first_core(node); core < resources.end_core(node); ++core) {
    if (use[static_cast<std::size_t>(core)] == wanted) cores.push_back(core);
  }
  return cores;
}

std::int64_t memory_on_node(const TaskSpec& spec, int cores) {
  return spec.cores() == 0 ? 0 : spec.memory_bytes / spec.cores() * cores;
}

/// Cores of one node: idle ones as far as they go, then those that are being given up, then fillers'.
std::vector<int> cores_of_node(const Resources& resources, int node, const std::vector<Use>& use, int count) {
  std::vector<int> chosen;
  for (const Use wanted : {Use::free, Use::leaving, Use::filler}) {
    const std::vector<int> cores = cores_of_use(resources, node, use, wanted);
    const std::vector<int> some =
        nearest(cores, std::min(cores.size(), static_cast<std::size_t>(count) - chosen.size()));
    chosen.insert(chosen.end(), some.begin(), some.end());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::optional<std::vector<int>> choose_on(int n_nodes, const TaskSpec& spec, const Resources& resources,
                                          const Availability& available) {
  const std::vector<Use>& use = available.use;
  struct Candidate {
    int node, free = 0, leaving = 0, lent = 0;  ///< cores of each use
    int available() const { return free + leaving + lent; }
    /// What is worse about taking `count` cores here: fillers that must give way, then waiting for some to end, then a
    /// loose fit (large nodes should stay whole).
    std::array<int, 3> cost(int count) const {
      return {std::max(0, count - free - leaving), std::max(0, count - free), available()};
    }
  };
  std::vector<Candidate> candidates;
  for (int node = 0; node < resources.n_nodes(); ++node) {
    Candidate candidate{node};
    for (int core = resources.first_core(node); core < resources.end_core(node); ++core) {
      candidate.free += use[static_cast<std::size_t>(core)] == Use::free;
      candidate.leaving += use[static_cast<std::size_t>(core)] == Use::leaving;
      candidate.lent += use[static_cast<std::size_t>(core)] == Use::filler;
    }
    candidates.push_back(candidate);
  }
  std::vector<int> chosen;
  for (const int count : cores_by_node(spec, n_nodes)) {
    auto best = candidates.end();
    for (auto it = candidates.begin(); it != candidates.end(); ++it) {
      const std::int64_t memory = available.free_memory[static_cast<std::size_t>(it->node)];
      const bool fits = it->available() >= count && memory >= memory_on_node(spec, count);
      if (fits && (best == candidates.end() || it->cost(count) < best->cost(count))) best = it;
    }
    if (best == candidates.end()) return std::nullopt;
    const std::vector<int> cores = cores_of_node(resources, best->node, use, count);
    chosen.insert(chosen.end(), cores.begin(), cores.end());
    candidates.erase(best);
  }
  return chosen;
}

}  // namespace

std::vector<int> cores_by_node(const TaskSpec& spec, int nodes) {
  std::vector<int> counts;
  for (int k = 0; k < nodes; ++k) counts.push_back((spec.ranks / nodes + (k < spec.ranks % nodes)) * spec.threads);
  return counts;
}

int fewest_nodes(const TaskSpec& spec, const Machine& machine) {
  std::vector<int> sizes;
  for (const Node& node : machine.nodes) sizes.push_back(static_cast<int>(node.cpus.size()));
  std::sort(sizes.rbegin(), sizes.rend());
  const int low = spec.nodes > 0 ? spec.nodes : 1;
  const int high = spec.nodes > 0 ? spec.nodes : std::min<int>(spec.ranks, static_cast<int>(sizes.size()));
  for (int nodes = low; nodes <= high && nodes <= static_cast<int>(sizes.size()); ++nodes) {
    const std::vector<int> counts = cores_by_node(spec, nodes);
    if (std::equal(counts.begin(), counts.end(), sizes.begin(), [](int need, int size) { return need <= size; }))
      return nodes;
  }
  return 0;
}

std::optional<std::vector<int>> choose_cores(const TaskSpec& spec, const Resources& resources,
                                             const Availability& available) {
  const int nodes = fewest_nodes(spec, resources.machine());
  if (nodes == 0) return std::nullopt;
  return choose_on(nodes, spec, resources, available);
}

void take_memory(const TaskSpec& spec, const std::vector<int>& cores, const Resources& resources,
                 Availability& available) {
  if (spec.memory_bytes == 0) return;
  for (const int core : cores) {
    available.free_memory[static_cast<std::size_t>(resources.node_of(core))] -= memory_on_node(spec, 1);
  }
}

std::vector<int> cores_to_wait_for(const TaskSpec& spec, const Resources& resources, const std::vector<Use>& use,
                                   const std::vector<bool>& reserved) {
  const int n_nodes = fewest_nodes(spec, resources.machine());
  std::vector<int> order(static_cast<std::size_t>(resources.n_nodes()));
  std::iota(order.begin(), order.end(), 0);
  std::vector<int> available(order.size(), 0), unreserved(order.size(), 0);
  for (int core = 0; core < resources.n_cores(); ++core) {
    const auto node = static_cast<std::size_t>(resources.node_of(core));
    available[node] += use[static_cast<std::size_t>(core)] != Use::taken;
    unreserved[node] += !reserved[static_cast<std::size_t>(core)];
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return available[static_cast<std::size_t>(a)] > available[static_cast<std::size_t>(b)];
  });
  std::vector<int> cores;
  std::vector<bool> used(order.size(), false);
  for (const int count : cores_by_node(spec, n_nodes)) {
    for (const int node : order) {
      if (used[static_cast<std::size_t>(node)] || unreserved[static_cast<std::size_t>(node)] < count) continue;
      used[static_cast<std::size_t>(node)] = true;
      int missing = count;
      for (const bool want_available : {true, false}) {
        for (int core = resources.first_core(node); core < resources.end_core(node) && missing > 0; ++core) {
          const auto k = static_cast<std::size_t>(core);
          if (reserved[k] || (use[k] != Use::taken) != want_available) continue;
          cores.push_back(core);
          --missing;
        }
      }
      break;
    }
  }
  return cores;
}

}  // namespace granary::pilot
