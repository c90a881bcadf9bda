#include "pilot/schedule/ready_queue.hpp"

#include <cmath>

namespace granary::pilot {
namespace {

/// A turn as a number: the smaller, the earlier.
std::uint64_t number_of(const Turn& turn) {
  const auto later = static_cast<std::uint64_t>(std::int64_t{std::numeric_limits<int>::max()} - turn.priority);
  return later << 31U | static_cast<std::uint64_t>(turn.id.value);
}

std::optional<TaskId> task_of(std::uint64_t number) {
  if (number == MinTree::kNone) return std::nullopt;
  return TaskId{static_cast<int>(number & 0x7fffffffU)};
}

Turn turn_of(const Task& task) { return {task.spec.priority, task.id}; }

}  // namespace

int ReadyQueue::bucket_of(double duration) {
  if (duration <= 0.0) return kBuckets - 1;
  int bucket = 0;
  while (bucket < kBuckets - 1 && duration > longest_in(bucket)) ++bucket;
  return bucket;
}

double ReadyQueue::longest_in(int bucket) { return std::ldexp(1.0, bucket - 4); }

void ReadyQueue::insert(const Task& task, const Layout& layout) {
  const Key key{layout, bucket_of(task.spec.duration()), task.spec.placement == Placement::spread};
  auto [found, is_new] = groups_.try_emplace(key);
  Group& group = found->second;
  if (is_new) {
    group.layout = layout;
    group.bucket = key.bucket;
    if (levels_.size() <= static_cast<std::size_t>(layout.small))
      levels_.resize(static_cast<std::size_t>(layout.small) + 1);
    levels_[static_cast<std::size_t>(layout.small)].groups[{key.bucket, layout.nodes}].push_back(&group);
  }
  if (group_of_.size() <= index(task.id)) group_of_.resize(std::max(index(task.id) + 1, 2 * group_of_.size()), nullptr);
  group_of_[index(task.id)] = &group;
  ++size_;
  group.tasks.insert(turn_of(task));
  if (group.tasks.begin()->id == task.id) refresh(group);
}

void ReadyQueue::erase(const Task& task) {
  if (!has(task.id)) return;
  Group& group = *group_of_[index(task.id)];
  const bool was_first = group.tasks.begin()->id == task.id;
  group.tasks.erase(turn_of(task));
  group_of_[index(task.id)] = nullptr;
  --size_;
  if (was_first) refresh(group);
}

/// Writes the first turn among the groups of the same cores, nodes and duration into the trees.
void ReadyQueue::refresh(const Group& group) {
  Level& level = levels_[static_cast<std::size_t>(group.layout.small)];
  const int nodes = group.layout.nodes;
  std::uint64_t first = MinTree::kNone;
  for (const Group* other : level.groups[{group.bucket, nodes}]) {
    if (!other->passed && !other->tasks.empty()) first = std::min(first, number_of(*other->tasks.begin()));
  }
  MinTree& own = level.by_duration[static_cast<std::size_t>(group.bucket)];
  const std::uint64_t before = own.at(nodes);
  if (first == before) return;
  own.set(nodes, first);
  std::uint64_t any = std::min(first, level.any.at(nodes));
  if (any == before) {  // it was the first of all; who is it now?
    any = first;
    for (const MinTree& tree : level.by_duration) any = std::min(any, tree.at(nodes));
  }
  level.any.set(nodes, any);
  tops_.set(group.layout.small, level.any.smallest());
}

std::optional<TaskId> ReadyQueue::first() const {
  std::uint64_t first = tops_.smallest();
  for (const auto* groups : {&passed_, &passed_for_memory_}) {
    for (const Group* group : *groups) {
      if (!group->tasks.empty()) first = std::min(first, number_of(*group->tasks.begin()));
    }
  }
  return task_of(first);
}

std::optional<TaskId> ReadyQueue::first_fitting(const NodeIndex& nodes) const {
  const std::vector<int>& at_least = nodes.at_least();
  std::uint64_t first = MinTree::kNone;
  for (std::size_t cores = 1; cores < std::min(levels_.size(), at_least.size()) && at_least[cores] > 0; ++cores) {
    if (tops_.at(static_cast<int>(cores)) < first)
      first = std::min(first, levels_[cores].any.smallest_up_to(at_least[cores]));
  }
  return task_of(first);
}

std::optional<TaskId> ReadyQueue::first_fitting(const NodeIndex& nodes, double duration) const {
  const std::vector<int>& at_least = nodes.at_least();
  std::uint64_t first = MinTree::kNone;
  for (std::size_t cores = 1; cores < std::min(levels_.size(), at_least.size()) && at_least[cores] > 0; ++cores) {
    if (tops_.at(static_cast<int>(cores)) >= first) continue;
    const Level& level = levels_[cores];
    if (level.any.smallest_up_to(at_least[cores]) >= first) continue;
    for (int bucket = 0; bucket < kBuckets - 1 && longest_in(bucket) <= duration; ++bucket)
      first = std::min(first, level.by_duration[static_cast<std::size_t>(bucket)].smallest_up_to(at_least[cores]));
  }
  return task_of(first);
}

void ReadyQueue::pass_over(TaskId id, bool for_memory) {
  Group& group = *group_of_[index(id)];
  group.passed = true;
  (for_memory ? passed_for_memory_ : passed_).push_back(&group);
  refresh(group);
}

void ReadyQueue::restore() {
  for (Group* group : passed_) {
    group->passed = false;
    refresh(*group);
  }
  passed_.clear();
}

void ReadyQueue::restore_memory(const std::function<bool(const Layout&)>& could_fit) {
  const auto restored = [&](Group* group) {
    if (!could_fit(group->layout)) return false;
    group->passed = false;
    refresh(*group);
    return true;
  };
  std::erase_if(passed_for_memory_, restored);
}

}  // namespace granary::pilot
