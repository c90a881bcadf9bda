// Nodes sorted by how many of their cores are to be had: a node moves, and the tightest fit is found, in O(1).
#pragma once

#include <vector>

#include "pilot/task/number_set.hpp"

namespace granary::pilot {

class NodeIndex {
 public:
  NodeIndex(int n_nodes, int largest);
  /// Node `node` has `count` cores to be had; nodes begin with 0.
  void set(int node, int count);
  int count(int node) const { return count_[static_cast<std::size_t>(node)]; }
  int largest() const { return static_cast<int>(nodes_.size()) - 1; }
  /// Nodes with at least c cores, for c = 0 .. largest().
  const std::vector<int>& at_least() const { return at_least_; }
  /// The first node with exactly `count` cores that is not below `from`; -1: none.
  int next(int count, int from) const { return nodes_[static_cast<std::size_t>(count)].next(from); }

 private:
  std::vector<int> count_;        ///< by node
  std::vector<NumberSet> nodes_;  ///< by count
  std::vector<int> at_least_;
};

}  // namespace granary::pilot
