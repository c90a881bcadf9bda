// Which task holds which core and how much memory of a node. Only book-keeping: who gets what is schedule/scheduler.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "common/result.hpp"
#include "pilot/schedule/machine.hpp"
#include "pilot/task/table.hpp"

namespace granary::pilot {

class Resources {
 public:
  explicit Resources(Machine machine);

  const Machine& machine() const { return machine_; }
  int n_cores() const { return static_cast<int>(holder_.size()); }
  int n_free() const { return n_free_; }
  /// Whether tasks may be given cores of this node: false between lose_node() and regain_node().
  bool is_up(int node) const { return up_[static_cast<std::size_t>(node)]; }
  void lose_node(int node) { up_[static_cast<std::size_t>(node)] = false; }
  void regain_node(int node) { up_[static_cast<std::size_t>(node)] = true; }
  /// The task on a core; nobody's id if it is free.
  TaskId holder(int core) const { return holder_[static_cast<std::size_t>(core)]; }
  bool is_free(int core) const { return holder(core) == TaskId{}; }
  int node_of(int core) const { return node_of_[static_cast<std::size_t>(core)]; }
  int first_core(int node) const { return first_core_[static_cast<std::size_t>(node)]; }
  int end_core(int node) const { return first_core_[static_cast<std::size_t>(node) + 1]; }
  int n_nodes() const { return static_cast<int>(first_core_.size()) - 1; }
  /// Memory of a node that no task has asked for [bytes]; a node of unknown memory has always enough.
  std::int64_t free_memory(int node) const;

  /// Gives free cores to a task, and memory the first time it gets any. A core that is not free is our own mistake.
  void take(const Task& task, const std::vector<int>& cores);
  /// Takes a task's cores back; its memory too unless it keeps it (a suspended one).
  void release(TaskId id, bool keep_memory = false);

 private:
  Machine machine_;
  std::vector<TaskId> holder_;              ///< by core
  std::vector<int> node_of_;                ///< by core
  std::vector<int> first_core_;             ///< by node, and the end
  std::vector<std::int64_t> memory_taken_;  ///< by node [bytes]
  std::vector<bool> up_;                    ///< by node
  int n_free_ = 0;
  std::unordered_map<int, std::vector<int>> cores_of_;                            ///< by task id
  std::unordered_map<int, std::vector<std::pair<int, std::int64_t>>> memory_of_;  ///< by task id: node, bytes
};

}  // namespace granary::pilot
