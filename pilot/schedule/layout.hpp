// How a task's ranks are shared out over nodes: how many nodes, how many cores on each. Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "pilot/schedule/machine.hpp"
#include "pilot/task/spec.hpp"

namespace granary::pilot {

/// As even as it goes: 5 ranks x 2 threads on 2 nodes: one node with 6 cores, one with 4.
struct Layout {
  int nodes = 0;             ///< 0: the task does not fit, however empty the machine is
  int large = 0, small = 0;  ///< cores on a node of the larger and of the smaller share
  int n_large = 0;           ///< nodes with the larger share; the others have the smaller
  std::int64_t memory = 0;   ///< bytes a core

  int cores_on(int k) const { return k < n_large ? large : small; }
  auto operator<=>(const Layout&) const = default;  // NOLINT(modernize-use-nullptr): clang-tidy 14 mistakes <=>
};

/// The layouts of one machine.
class Layouts {
 public:
  explicit Layouts(const Machine& machine);
  /// On as few nodes as the empty machine has room for it, or on as many as the task asks for.
  Layout of(const TaskSpec& spec) const;
  /// Memory of the node that has most [bytes]; 0: of some node nobody knows.
  std::int64_t largest_memory() const { return largest_memory_; }
  int n_cores() const { return n_cores_; }
  int n_nodes() const { return static_cast<int>(sizes_.size()); }
  int largest_node() const { return sizes_.empty() ? 0 : sizes_.front(); }

 private:
  std::vector<int> sizes_;  ///< cores of each node, largest first
  std::int64_t largest_memory_ = 0;
  int n_cores_ = 0;
};

/// Cores on each of the nodes that the ranks are spread over, largest first: 5 ranks x 2 threads on 2 nodes: {6, 4}.
std::vector<int> cores_by_node(const Layout& layout);

}  // namespace granary::pilot
