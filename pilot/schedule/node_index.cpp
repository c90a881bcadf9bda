#include "pilot/schedule/node_index.hpp"

namespace granary::pilot {

NodeIndex::NodeIndex(int n_nodes, int largest)
    : count_(static_cast<std::size_t>(n_nodes), 0),
      nodes_(static_cast<std::size_t>(largest) + 1),
      at_least_(static_cast<std::size_t>(largest) + 1, 0) {
  for (int node = 0; node < n_nodes; ++node) nodes_[0].insert(node);
  at_least_[0] = n_nodes;
}

void NodeIndex::set(int node, int count) {
  const int now = count_[static_cast<std::size_t>(node)];
  if (now == count) return;
  nodes_[static_cast<std::size_t>(now)].erase(node);
  nodes_[static_cast<std::size_t>(count)].insert(node);
  for (int c = now + 1; c <= count; ++c) ++at_least_[static_cast<std::size_t>(c)];
  for (int c = count + 1; c <= now; ++c) --at_least_[static_cast<std::size_t>(c)];
  count_[static_cast<std::size_t>(node)] = count;
}

}  // namespace granary::pilot
