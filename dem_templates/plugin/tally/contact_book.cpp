#include "dem_templates/plugin/tally/contact_book.hpp"

#include <algorithm>

namespace granary::dem {
namespace {

constexpr std::size_t kHead = 7;  // pairs, known, velocity, bodies, axial

}  // namespace

// Half of the table is free at least, so that a search is short.
std::size_t ContactBook::place(const Pair& pair) const {
  constexpr std::uint64_t kMix =
      0x9e3779b97f4a7c15;  // 2^64 over the golden ratio: the upper bits of the product differ
  const std::uint64_t hash =
      (static_cast<std::uint64_t>(pair.first) * kMix + static_cast<std::uint64_t>(pair.second)) * kMix >> 32;
  const std::size_t last = table_.size() - 1;
  std::size_t at = hash & last;
  while (table_[at] != 0 && pairs_[table_[at] - 1] != pair) at = (at + 1) & last;
  return at;
}

void ContactBook::note_pair(std::int64_t owner, std::int64_t other) {
  pairs_.push_back({owner, other});
  if (2 * pairs_.size() <= table_.size()) {
    table_[place(pairs_.back())] = static_cast<std::uint32_t>(pairs_.size());
    return;
  }
  table_.assign(std::max<std::size_t>(64, 2 * table_.size()), 0);
  for (std::size_t k = 0; k < pairs_.size(); ++k) table_[place(pairs_[k])] = static_cast<std::uint32_t>(k + 1);
}

bool ContactBook::touched(std::int64_t owner, std::int64_t other) const {
  return !pairs_.empty() && table_[place({owner, other})] != 0;
}

void ContactBook::forget_pairs() {
  pairs_.clear();
  std::fill(table_.begin(), table_.end(), 0);
}

std::size_t ContactBook::largest_packed() const {
  std::vector<std::int64_t> owners;
  for (const Pair& pair : pairs_) owners.push_back(pair.first);
  std::sort(owners.begin(), owners.end());
  std::size_t most = 0, run = 0;
  for (std::size_t k = 0; k < owners.size(); ++k) {
    run = k > 0 && owners[k] == owners[k - 1] ? run + 1 : 1;
    most = std::max(most, run);
  }
  return kHead + most;
}

std::size_t ContactBook::pack(std::size_t particle, std::int64_t tag, double* buffer) const {
  const Memory& memory = memories_[particle];
  double* end = buffer;
  *end++ = 0.0;
  *end++ = memory.known ? 1.0 : 0.0;
  end = std::copy(memory.velocity.begin(), memory.velocity.end(), end);
  *end++ = static_cast<double>(memory.bodies);
  *end++ = memory.axial;
  for (const Pair& pair : pairs_) {
    if (pair.first != tag) continue;
    *end++ = static_cast<double>(pair.second);
    buffer[0] += 1.0;
  }
  return static_cast<std::size_t>(end - buffer);
}

std::size_t ContactBook::unpack(std::size_t particle, std::int64_t tag, const double* buffer) {
  Memory& memory = memories_[particle];
  const auto n = static_cast<std::size_t>(buffer[0]);
  memory.known = buffer[1] != 0.0;
  std::copy(buffer + 2, buffer + 5, memory.velocity.begin());
  memory.bodies = static_cast<std::uint64_t>(buffer[5]);
  memory.axial = buffer[6];
  for (std::size_t k = 0; k < n; ++k) note_pair(tag, static_cast<std::int64_t>(buffer[kHead + k]));
  return kHead + n;
}

}  // namespace granary::dem
