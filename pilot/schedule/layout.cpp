#include "pilot/schedule/layout.hpp"

#include <algorithm>
#include <functional>

namespace granary::pilot {
namespace {

Layout layout_on(const TaskSpec& spec, int nodes) {
  const int ranks = spec.ranks / nodes, more = spec.ranks % nodes;
  Layout layout;
  layout.nodes = nodes;
  layout.small = ranks * spec.threads;
  layout.large = (ranks + (more > 0)) * spec.threads;
  layout.n_large = more > 0 ? more : nodes;
  layout.memory = spec.memory_bytes / spec.cores();
  return layout;
}

}  // namespace

Layouts::Layouts(const Machine& machine) {
  for (const Node& node : machine.nodes) sizes_.push_back(static_cast<int>(node.cpus.size()));
  bool known = true;
  for (const Node& node : machine.nodes) {
    known = known && node.memory_bytes > 0;
    largest_memory_ = std::max(largest_memory_, node.memory_bytes);
    n_cores_ += static_cast<int>(node.cpus.size());
  }
  if (!known) largest_memory_ = 0;
  std::sort(sizes_.begin(), sizes_.end(), std::greater<>());
}

Layout Layouts::of(const TaskSpec& spec) const {
  if (spec.cores() <= 0 || sizes_.empty() || sizes_.front() == 0) return {};
  const int n_nodes = static_cast<int>(sizes_.size());
  const int ranks_a_node = sizes_.front() / spec.threads;
  if (ranks_a_node == 0) return {};
  const int fewest = (spec.ranks + ranks_a_node - 1) / ranks_a_node;
  const int low = spec.nodes > 0 ? spec.nodes : fewest;
  const int high = std::min(spec.nodes > 0 ? spec.nodes : spec.ranks, n_nodes);
  for (int nodes = low; nodes <= high; ++nodes) {
    const Layout layout = layout_on(spec, nodes);
    // Sizes fall, and so do the shares: the last node of each share decides.
    if (layout.large <= sizes_[static_cast<std::size_t>(layout.n_large - 1)] &&
        layout.small <= sizes_[static_cast<std::size_t>(nodes - 1)])
      return layout;
  }
  return {};
}

std::vector<int> cores_by_node(const Layout& layout) {
  std::vector<int> counts;
  for (int k = 0; k < layout.nodes; ++k) counts.push_back(layout.cores_on(k));
  return counts;
}

}  // namespace granary::pilot
