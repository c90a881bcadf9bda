#include "pilot/schedule/ready_queue.hpp"

#include <algorithm>
#include <boost/container_hash/hash.hpp>
#include <cmath>
#include <functional>

namespace granary::pilot {
namespace {

/// A task's turn as a number: the smaller, the earlier.
std::uint64_t number_of(const Task& task) {
  const auto later = static_cast<std::uint64_t>(std::int64_t{std::numeric_limits<int>::max()} - task.spec.priority);
  return later << 31U | static_cast<std::uint64_t>(task.id.value);
}

std::optional<TaskId> task_of(std::uint64_t number) {
  if (number == MinTree::kNone) return std::nullopt;
  return TaskId{static_cast<int>(number & 0x7fffffffU)};
}

}  // namespace

std::size_t ReadyQueue::HashKey::operator()(const Key& key) const {
  std::size_t hash = 0;
  for (const auto part : {key.layout.nodes, key.layout.large, key.layout.small, key.bucket * 2 + key.spread})
    boost::hash_combine(hash, part);
  boost::hash_combine(hash, key.layout.memory);
  return hash;
}

int ReadyQueue::bucket_of(double duration) {
  if (duration <= 0.0) return kBuckets - 1;
  int exponent = 0;
  const double mantissa = std::frexp(duration, &exponent);  // in [0.5, 1)
  return std::clamp(exponent - (mantissa == 0.5) + 4, 0, kBuckets - 1);
}

double ReadyQueue::longest_in(int bucket) {
  static const auto longest = [] {
    std::array<double, kBuckets> durations{};
    for (int b = 0; b < kBuckets; ++b) durations[static_cast<std::size_t>(b)] = std::ldexp(1.0, b - 4);
    return durations;
  }();
  return longest[static_cast<std::size_t>(bucket)];
}

ReadyQueue::Group& ReadyQueue::group_for(const Key& key) {
  const auto [found, is_new] = groups_.try_emplace(key);
  Group& group = found->second;
  if (!is_new) return group;
  group.layout = key.layout;
  group.bucket = key.bucket;
  const auto level = static_cast<std::size_t>(key.layout.small);
  if (levels_.size() <= level) levels_.resize(level + 1);
  const auto [site, first_there] = levels_[level].sites.try_emplace(key.layout.nodes);
  if (first_there) site->second.first.fill(MinTree::kNone);
  group.site = &site->second;
  group.peers = &group.site->groups[key.bucket];
  group.place = group.peers->count++;
  return group;
}

void ReadyQueue::insert(const Task& task, const Layout& layout) {
  Group& group = group_for({layout, bucket_of(task.spec.duration()), task.spec.placement == Placement::spread});
  if (group_of_.size() <= index(task.id)) group_of_.resize(std::max(index(task.id) + 1, 2 * group_of_.size()), nullptr);
  group_of_[index(task.id)] = &group;
  ++size_;
  const std::uint64_t number = number_of(task);
  group.turns.push(number);
  if (group.first() == number) refresh(group);
}

void ReadyQueue::erase(const Task& task) {
  if (!has(task.id)) return;
  Group& group = *std::exchange(group_of_[index(task.id)], nullptr);
  --size_;
  if (group.first() != number_of(task)) return;
  while (!group.turns.empty() && group_of_[index(*task_of(group.first()))] != &group) group.turns.pop();
  refresh(group);
}

/// Writes the first turn among the groups of the same cores, nodes and duration into the trees.
void ReadyQueue::refresh(const Group& group) {
  Level& level = levels_[static_cast<std::size_t>(group.layout.small)];
  const int nodes = group.layout.nodes;
  group.peers->first.set(group.place, group.passed ? MinTree::kNone : group.first());
  const std::uint64_t first = group.peers->first.smallest();
  std::uint64_t& now = group.site->first[static_cast<std::size_t>(group.bucket)];
  if (first == now) return;
  now = first;
  level.by_duration[static_cast<std::size_t>(group.bucket)].set(nodes, first);
  level.any.set(nodes, *std::min_element(group.site->first.begin(), group.site->first.end()));
  tops_.set(group.layout.small, level.any.smallest());
}

std::optional<TaskId> ReadyQueue::first() const {
  std::uint64_t first = tops_.smallest();
  for (const auto* groups : {&passed_, &passed_for_memory_}) {
    for (const Group* group : *groups) first = std::min(first, group->first());
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
