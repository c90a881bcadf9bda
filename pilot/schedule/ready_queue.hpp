// Ready tasks by turn, grouped by what decides where and how long they may run: finding the first that fits is O(log)
// in their number, for a whole group fits or none of it does.
#pragma once

#include <array>
#include <boost/heap/d_ary_heap.hpp>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "pilot/schedule/layout.hpp"
#include "pilot/schedule/min_tree.hpp"
#include "pilot/schedule/node_index.hpp"
#include "pilot/task/table.hpp"

namespace granary::pilot {

class ReadyQueue {
 public:
  void insert(const Task& task, const Layout& layout);
  void erase(const Task& task);
  bool has(TaskId id) const { return index(id) < group_of_.size() && group_of_[index(id)] != nullptr; }
  bool empty() const { return size_ == 0; }
  const Layout& layout(TaskId id) const { return group_of_[index(id)]->layout; }

  /// The first in turn, passed over or not.
  std::optional<TaskId> first() const;
  /// The first in turn that is not passed over and for whose smaller share there are nodes enough. That its larger
  /// share and its memory fit too is for the caller to find out.
  std::optional<TaskId> first_fitting(const NodeIndex& nodes) const;
  /// Likewise, of those that are known to take at most `duration` [s].
  std::optional<TaskId> first_fitting(const NodeIndex& nodes, double duration) const;

  /// Passes the task's group over, until restore(). If it is for want of memory alone: until restore_memory() is told
  /// of a node that could help.
  void pass_over(TaskId id, bool for_memory);
  void restore();
  void restore_memory(const std::function<bool(const Layout&)>& could_fit);

 private:
  // Durations by powers of 2 [s]: bucket b holds those up to 2^(b-4); the last one those that are unknown or longer.
  static constexpr int kBuckets = 28;
  /// Turns as numbers, the first on top. What was erased behind it stays until it comes to the top. Each node of the
  /// heap lies with its brothers in one line of the cache.
  using Turns =
      boost::heap::d_ary_heap<std::uint64_t, boost::heap::arity<8>, boost::heap::compare<std::greater<std::uint64_t>>>;
  /// The groups of one site and bucket.
  struct Peers {
    int count = 0;
    MinTree first;  ///< turn of each; none: passed over
  };
  struct Site;
  struct Group {
    Layout layout;
    int bucket = 0;
    bool passed = false;
    Turns turns;
    Site* site = nullptr;
    Peers* peers = nullptr;
    int place = 0;  ///< among its peers

    std::uint64_t first() const { return turns.empty() ? MinTree::kNone : turns.top(); }
  };
  /// The groups of as many cores a node on as many nodes.
  struct Site {
    std::array<std::uint64_t, kBuckets> first;  ///< turn by bucket
    std::map<int, Peers> groups;                ///< by bucket
  };
  struct Key {
    Layout layout;
    int bucket = 0;
    bool spread = false;
    bool operator==(const Key&) const = default;
  };
  struct HashKey {
    std::size_t operator()(const Key& key) const;
  };
  /// The sites of as many cores a node: the first turn by nodes.
  struct Level {
    MinTree any;
    std::array<MinTree, kBuckets> by_duration;
    std::map<int, Site> sites;  ///< by nodes
  };

  static std::size_t index(TaskId id) { return static_cast<std::size_t>(id.value); }
  static int bucket_of(double duration);
  static double longest_in(int bucket);
  Group& group_for(const Key& key);
  void refresh(const Group& group);

  std::unordered_map<Key, Group, HashKey> groups_;
  std::vector<Group*> group_of_;  ///< by task id
  std::size_t size_ = 0;
  std::deque<Level> levels_;  ///< by cores a node
  MinTree tops_;              ///< the first turn of each level
  std::vector<Group*> passed_, passed_for_memory_;
};

}  // namespace granary::pilot
