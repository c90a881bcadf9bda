#include "pilot/schedule/resources.hpp"

#include <limits>
#include <map>

namespace granary::pilot {

Resources::Resources(Machine machine) : machine_(std::move(machine)) {
  for (std::size_t node = 0; node < machine_.nodes.size(); ++node) {
    first_core_.push_back(static_cast<int>(node_of_.size()));
    node_of_.insert(node_of_.end(), machine_.nodes[node].cpus.size(), static_cast<int>(node));
  }
  first_core_.push_back(static_cast<int>(node_of_.size()));
  holder_.assign(node_of_.size(), TaskId{});
  up_.assign(machine_.nodes.size(), true);
  memory_taken_.assign(machine_.nodes.size(), 0);
  n_free_ = static_cast<int>(holder_.size());
}

std::int64_t Resources::free_memory(int node) const {
  const std::int64_t all = machine_.nodes[static_cast<std::size_t>(node)].memory_bytes;
  if (all == 0) return std::numeric_limits<std::int64_t>::max();
  return all - memory_taken_[static_cast<std::size_t>(node)];
}

void Resources::take(const Task& task, const std::vector<int>& cores) {
  for (const int core : cores) {
    GRANARY_ASSERT(is_free(core), core);
    holder_[static_cast<std::size_t>(core)] = task.id;
  }
  n_free_ -= static_cast<int>(cores.size());
  cores_of_[task.id.value] = cores;
  if (task.spec.memory_bytes == 0 || cores.empty() || memory_of_.count(task.id.value) != 0) return;
  std::map<int, std::int64_t> cores_on;
  for (const int core : cores) ++cores_on[node_of(core)];
  for (const auto& [node, count] : cores_on) {
    const std::int64_t share = task.spec.memory_bytes / static_cast<std::int64_t>(cores.size()) * count;
    memory_taken_[static_cast<std::size_t>(node)] += share;
    memory_of_[task.id.value].emplace_back(node, share);
  }
}

void Resources::release(TaskId id, bool keep_memory) {
  if (const auto held = cores_of_.find(id.value); held != cores_of_.end()) {
    for (const int core : held->second) holder_[static_cast<std::size_t>(core)] = TaskId{};
    n_free_ += static_cast<int>(held->second.size());
    cores_of_.erase(held);
  }
  if (keep_memory) return;
  if (const auto memory = memory_of_.find(id.value); memory != memory_of_.end()) {
    for (const auto& [node, bytes] : memory->second) memory_taken_[static_cast<std::size_t>(node)] -= bytes;
    memory_of_.erase(memory);
  }
}

}  // namespace granary::pilot
