// Which task holds which core and how much memory of a node, which cores are kept for whom, and which nodes have how
// many to give. Only book-keeping, O(1) a node touched: who gets what is schedule/scheduler.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "pilot/schedule/machine.hpp"
#include "pilot/schedule/node_index.hpp"
#include "pilot/task/core_set.hpp"
#include "pilot/task/spec.hpp"

namespace granary::pilot {

/// What a task takes.
struct Hold {
  CoreSet cores;
  std::int64_t memory = 0;  ///< bytes a core; 0: not counted
  double end = 0.0;         ///< when it is expected to leave them [s]; infinity: unknown
  bool lends = false;       ///< a filler: gives way to any ready task
  TaskId task;              ///< whose it is; take() notes it
};

class Resources {
 public:
  explicit Resources(Machine machine);

  const Machine& machine() const { return machine_; }
  int n_cores() const { return static_cast<int>(use_.size()); }
  int n_nodes() const { return static_cast<int>(first_core_.size()) - 1; }
  int n_free() const { return n_free_; }
  int n_down() const { return n_down_; }
  int n_lent() const { return n_lent_; }  ///< cores of fillers that give way
  int node_of(int core) const {
    // On equal nodes nothing is looked up: of hundreds of thousands of cores no table stays in the cache.
    return cores_each_ > 0 ? core / cores_each_ : node_of_[static_cast<std::size_t>(core)];
  }
  int first_core(int node) const { return first_core_[static_cast<std::size_t>(node)]; }
  int end_core(int node) const { return first_core_[static_cast<std::size_t>(node) + 1]; }
  bool is_up(int node) const { return nodes_[static_cast<std::size_t>(node)].up; }
  /// The task on a core; nobody's id if it is free.
  TaskId holder(int core) const { return is_free(core) ? TaskId{} : hold_on(core).task; }
  bool is_free(int core) const {
    const Use use = use_[static_cast<std::size_t>(core)];
    return use == Use::idle || use == Use::claimed;
  }
  bool is_claimed(int core) const { return claimed_[static_cast<std::size_t>(core)]; }
  /// Free, and nobody has a claim on it.
  bool is_idle(int core) const { return use_[static_cast<std::size_t>(core)] == Use::idle; }
  /// What a task holds now; nullptr: no core.
  const Hold* held_by(TaskId id) const;
  /// Memory of a node that no task has asked for [bytes]; a node of unknown memory has always enough.
  std::int64_t free_memory(int node) const;
  /// Nodes that can give more cores or memory than at the last forget_gained(); some several times.
  const std::vector<int>& gained() const { return gained_; }
  void forget_gained() { gained_.clear(); }

  /// Gives free cores to a task, and memory the first time it gets any. A core that is not free is our own mistake.
  void take(TaskId id, Hold hold);
  /// Takes a task's cores back; its memory too unless it keeps it (a suspended one).
  void release(TaskId id, bool keep_memory = false);
  void set_lends(TaskId id, bool lends);
  void lose_node(int node);
  void regain_node(int node);

  /// Cores kept for one task while the fillers on them end: nobody else's.
  void claim(const CoreSet& cores);
  void unclaim(const CoreSet& cores);
  /// `count` cores and some memory of a node kept for a waiting task, whichever they will be.
  void reserve(int node, int count, std::int64_t memory);
  void unreserve(int node);
  int reserved(int node) const { return nodes_[static_cast<std::size_t>(node)].reserved; }
  /// Memory a task may have that the reservation is not for.
  std::int64_t spare_memory(int node) const;

  // Nodes by cores to be had; "idle": without pushing a filler away; "spare": without what is reserved.
  const NodeIndex& spare_idle() const { return spare_idle_; }
  const NodeIndex& spare() const { return spare_; }
  const NodeIndex& reserved_idle() const { return reserved_idle_; }  ///< all of them, on nodes with a reservation only
  const NodeIndex& reserved_all() const { return reserved_all_; }
  int idle(int node) const { return nodes_[static_cast<std::size_t>(node)].idle; }
  /// Idle or a filler's, whatever is reserved.
  int available(int node) const;
  /// Whether so many available cores are there, with so much memory for each [bytes].
  bool has(int node, int cores, std::int64_t memory) const {
    return available(node) >= cores && (memory == 0 || free_memory(node) >= memory * cores);
  }

  /// When `count` cores of the node (and all its memory, if `empty`) will be available, by the expected ends [s];
  /// 0: now.
  double free_at(int node, int count, bool empty) const;
  /// Adds `count` available cores of the node: idle ones near each other, then fillers'.
  void pick(int node, int count, CoreSet& picked) const;

 private:
  enum class Use : char { taken, idle, lent, claimed };  ///< claimed: free, and kept for somebody
  struct NodeState {
    bool up = true;
    bool reserved_before = false;  ///< when its place in the indices was looked at last
    int idle = 0, lent = 0;        ///< cores
    int reserved = 0;
  };
  struct NodeMemory {
    std::int64_t all = 0, taken = 0, reserved = 0;  ///< [bytes]
  };

  const Hold& hold_on(int core) const {
    return holds_[static_cast<std::size_t>(hold_on_[static_cast<std::size_t>(core)])];
  }
  void set_use(int core, Use use);
  void reindex(int node);
  void number_cores();
  void set_use(const CoreSet& cores, Use from, Use to);
  Hold* find(TaskId id);

  Machine machine_;
  int cores_each_ = 0;           ///< of every node; 0: they are not equal
  std::vector<int> node_of_;     ///< by core, if they are not
  std::vector<int> first_core_;  ///< by node, and the end
  std::vector<Use> use_;         ///< by core
  std::vector<int> hold_on_;     ///< by core: its place in holds_; of a free one: of nobody's concern
  std::vector<bool> claimed_;    ///< by core
  std::vector<NodeState> nodes_;
  std::vector<NodeMemory> memory_;  ///< by node; few tasks ask for it
  NodeIndex spare_idle_, spare_, reserved_idle_, reserved_all_;
  int n_free_ = 0, n_down_ = 0, n_claimed_ = 0, n_lent_ = 0;
  std::vector<int> gained_;
  std::vector<Hold> holds_;      ///< in no order
  std::vector<int> free_holds_;  ///< of them: nobody's
  std::vector<int> hold_of_;     ///< by task id: its place in holds_; -1: none
  std::unordered_map<int, std::vector<std::pair<int, std::int64_t>>> memory_of_;  ///< by task id: node, bytes
};

}  // namespace granary::pilot
