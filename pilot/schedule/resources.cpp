#include "pilot/schedule/resources.hpp"

#include <algorithm>
#include <limits>

#include "common/assert.hpp"

namespace granary::pilot {
namespace {

std::size_t index(int number) { return static_cast<std::size_t>(number); }

/// The `count` of the sorted `cores` that span the shortest stretch.
void take_nearest(const std::vector<int>& cores, std::size_t count, std::vector<int>& chosen) {
  if (count == 0) return;
  std::size_t best = 0;
  for (std::size_t k = 1; k + count <= cores.size(); ++k) {
    if (cores[k + count - 1] - cores[k] < cores[best + count - 1] - cores[best]) best = k;
  }
  for (std::size_t k = best; k < best + count; ++k) chosen.push_back(cores[k]);
}

}  // namespace

Resources::Resources(Machine machine)
    : machine_(std::move(machine)),
      spare_idle_(static_cast<int>(machine_.nodes.size()), machine_.largest_node()),
      spare_(spare_idle_),
      reserved_idle_(spare_idle_),
      reserved_all_(spare_idle_) {
  for (std::size_t node = 0; node < machine_.nodes.size(); ++node) {
    first_core_.push_back(static_cast<int>(use_.size()));
    use_.insert(use_.end(), machine_.nodes[node].cpus.size(), Use::idle);
    NodeState state;
    state.idle = static_cast<int>(machine_.nodes[node].cpus.size());
    nodes_.push_back(state);
    memory_.push_back({machine_.nodes[node].memory_bytes, 0, 0});
  }
  first_core_.push_back(static_cast<int>(use_.size()));
  number_cores();
  hold_on_.assign(use_.size(), -1);
  claimed_.assign(use_.size(), false);
  n_free_ = n_cores();
  for (int node = 0; node < n_nodes(); ++node) reindex(node);
}

/// How node_of() finds its answer.
void Resources::number_cores() {
  const int largest = machine_.largest_node();
  if (largest * n_nodes() == n_cores()) {
    cores_each_ = largest;
    return;
  }
  for (int node = 0; node < n_nodes(); ++node)
    node_of_.insert(node_of_.end(), machine_.nodes[index(node)].cpus.size(), node);
}

const Hold* Resources::held_by(TaskId id) const {
  if (index(id.value) >= hold_of_.size() || hold_of_[index(id.value)] < 0) return nullptr;
  return &holds_[index(hold_of_[index(id.value)])];
}

Hold* Resources::find(TaskId id) { return const_cast<Hold*>(held_by(id)); }

std::int64_t Resources::free_memory(int node) const {
  const NodeMemory& memory = memory_[index(node)];
  return memory.all == 0 ? std::numeric_limits<std::int64_t>::max() : memory.all - memory.taken;
}

std::int64_t Resources::spare_memory(int node) const { return free_memory(node) - memory_[index(node)].reserved; }

int Resources::available(int node) const {
  const NodeState& state = nodes_[index(node)];
  return state.up ? state.idle + state.lent : 0;
}

void Resources::reindex(int node) {
  NodeState& state = nodes_[index(node)];
  const int idle = state.up ? state.idle : 0, all = available(node);
  const int spare = std::max(0, all - state.reserved);
  if (spare > spare_.count(node)) gained_.push_back(node);
  spare_.set(node, spare);
  spare_idle_.set(node, std::min(idle, spare));
  if (!state.reserved_before && state.reserved == 0) return;
  reserved_idle_.set(node, state.reserved > 0 ? idle : 0);
  reserved_all_.set(node, state.reserved > 0 ? all : 0);
  state.reserved_before = state.reserved > 0;
}

/// The caller reindexes the node.
void Resources::set_use(int core, Use use) {
  Use& now = use_[index(core)];
  NodeState& state = nodes_[index(node_of(core))];
  state.idle += (use == Use::idle) - (now == Use::idle);
  const int lent = (use == Use::lent) - (now == Use::lent);
  state.lent += lent;
  n_lent_ += lent;
  now = use;
}

/// Likewise of many, a stretch on one node at a time; reindexes the nodes.
void Resources::set_use(const CoreSet& cores, Use from, Use to) {
  cores.for_each_stretch([&](const CoreSet::Stretch& stretch) {
    const int last = stretch.first + stretch.count;
    for (int core = stretch.first, node = node_of(core); core < last; ++node) {
      const int stop = std::min(last, end_core(node));
      if (n_claimed_ == 0) {
        std::fill(use_.begin() + core, use_.begin() + stop, to);
        NodeState& state = nodes_[index(node)];
        state.idle += ((to == Use::idle) - (from == Use::idle)) * (stop - core);
        const int lent = ((to == Use::lent) - (from == Use::lent)) * (stop - core);
        state.lent += lent;
        n_lent_ += lent;
      } else {
        for (int k = core; k < stop; ++k) set_use(k, to == Use::idle && claimed_[index(k)] ? Use::claimed : to);
      }
      core = stop;
      reindex(node);
    }
  });
}

void Resources::take(TaskId id, Hold hold) {
  hold.cores.for_each([&](int core) { GRANARY_ASSERT(is_free(core), core); });
  set_use(hold.cores, Use::idle, hold.lends ? Use::lent : Use::taken);
  n_free_ -= hold.cores.size();
  if (hold.memory > 0 && !hold.cores.empty() && memory_of_.count(id.value) == 0) {
    auto& shares = memory_of_[id.value];
    hold.cores.for_each([&](int core) {
      if (shares.empty() || shares.back().first != node_of(core)) shares.emplace_back(node_of(core), 0);
      shares.back().second += hold.memory;
    });
    for (const auto& [where, bytes] : shares) memory_[index(where)].taken += bytes;
  }
  if (hold_of_.size() <= index(id.value)) hold_of_.resize(std::max(index(id.value) + 1, 2 * hold_of_.size()), -1);
  if (free_holds_.empty()) {
    free_holds_.push_back(static_cast<int>(holds_.size()));
    holds_.emplace_back();
  }
  const int place = free_holds_.back();
  free_holds_.pop_back();
  hold.cores.for_each_stretch(
      [&](const CoreSet::Stretch& stretch) { std::fill_n(hold_on_.begin() + stretch.first, stretch.count, place); });
  hold.task = id;
  holds_[index(place)] = std::move(hold);
  hold_of_[index(id.value)] = place;
}

void Resources::release(TaskId id, bool keep_memory) {
  if (const Hold* held = held_by(id)) {
    set_use(held->cores, held->lends ? Use::lent : Use::taken, Use::idle);
    n_free_ += held->cores.size();
    free_holds_.push_back(std::exchange(hold_of_[index(id.value)], -1));
  }
  if (keep_memory || memory_of_.empty()) return;
  if (const auto memory = memory_of_.find(id.value); memory != memory_of_.end()) {
    for (const auto& [node, bytes] : memory->second) {
      memory_[index(node)].taken -= bytes;
      gained_.push_back(node);
    }
    memory_of_.erase(memory);
  }
}

void Resources::set_lends(TaskId id, bool lends) {
  Hold* held = find(id);
  if (held == nullptr || held->lends == lends) return;
  held->lends = lends;
  held->cores.for_each([&](int core) {
    const bool may = lends && !claimed_[index(core)];
    set_use(core, may ? Use::lent : Use::taken);
    reindex(node_of(core));
  });
}

void Resources::lose_node(int node) {
  if (!is_up(node)) return;
  nodes_[index(node)].up = false;
  ++n_down_;
  reindex(node);
}

void Resources::regain_node(int node) {
  if (is_up(node)) return;
  nodes_[index(node)].up = true;
  --n_down_;
  reindex(node);
}

void Resources::claim(const CoreSet& cores) {
  cores.for_each([&](int core) {
    claimed_[index(core)] = true;
    ++n_claimed_;
    if (use_[index(core)] != Use::taken) set_use(core, is_free(core) ? Use::claimed : Use::taken);
    reindex(node_of(core));
  });
}

void Resources::unclaim(const CoreSet& cores) {
  cores.for_each([&](int core) {
    claimed_[index(core)] = false;
    --n_claimed_;
    const Hold* hold = is_free(core) ? nullptr : held_by(holder(core));
    set_use(core, hold == nullptr ? Use::idle : hold->lends ? Use::lent : Use::taken);
    reindex(node_of(core));
  });
}

void Resources::reserve(int node, int count, std::int64_t memory) {
  nodes_[index(node)].reserved = count;
  memory_[index(node)].reserved = memory;
  reindex(node);
}

void Resources::unreserve(int node) { reserve(node, 0, 0); }

double Resources::free_at(int node, int count, bool empty) const {
  thread_local std::vector<double> ends;
  ends.clear();
  for (int core = first_core(node); core < end_core(node); ++core) {
    switch (use_[index(core)]) {
      case Use::taken:
        ends.push_back(hold_on(core).end);
        break;
      case Use::claimed:  // by somebody who has not even begun
        ends.push_back(std::numeric_limits<double>::infinity());
        break;
      default:
        ends.push_back(0.0);
    }
  }
  if (empty) return *std::max_element(ends.begin(), ends.end());
  const auto nth = ends.begin() + (count - 1);
  std::nth_element(ends.begin(), nth, ends.end());
  return *nth;
}

void Resources::pick(int node, int count, CoreSet& picked) const {
  const NodeState& state = nodes_[index(node)];
  if (state.idle == end_core(node) - first_core(node)) return picked.add(first_core(node), count);
  thread_local std::vector<int> chosen, cores;
  chosen.clear();
  for (const Use wanted : {Use::idle, Use::lent}) {
    const std::size_t missing = index(count) - chosen.size();
    if (missing == 0) break;
    cores.clear();
    for (int core = first_core(node); core < end_core(node); ++core) {
      if (use_[index(core)] != wanted) continue;
      cores.push_back(core);
      if (count == 1) break;
    }
    take_nearest(cores, std::min(cores.size(), missing), chosen);
  }
  std::sort(chosen.begin(), chosen.end());
  for (const int core : chosen) picked.add(core);
}

}  // namespace granary::pilot
