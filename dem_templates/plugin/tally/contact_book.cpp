#include "dem_templates/plugin/tally/contact_book.hpp"

#include <algorithm>

namespace granary::dem {
namespace {

constexpr std::size_t kHead = 7;  // pairs, known, velocity, bodies, axial

}  // namespace

void ContactBook::sort() {
  if (n_sorted_ == pairs_.size()) return;
  std::sort(pairs_.begin(), pairs_.end());
  n_sorted_ = pairs_.size();
}

bool ContactBook::touched(std::int64_t owner, std::int64_t other) {
  sort();
  return std::binary_search(pairs_.begin(), pairs_.end(), Pair{owner, other});
}

std::size_t ContactBook::largest_packed() {
  sort();
  std::size_t most = 0, run = 0;
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    run = k > 0 && pairs_[k].first == pairs_[k - 1].first ? run + 1 : 1;
    most = std::max(most, run);
  }
  return kHead + most;
}

std::size_t ContactBook::pack(std::size_t particle, std::int64_t tag, double* buffer) {
  sort();
  const Memory& memory = memories_[particle];
  const auto first = std::lower_bound(pairs_.begin(), pairs_.end(), Pair{tag, 0});
  const auto last = std::lower_bound(first, pairs_.end(), Pair{tag + 1, 0});
  buffer[0] = static_cast<double>(last - first);
  buffer[1] = memory.known ? 1.0 : 0.0;
  std::copy(memory.velocity.begin(), memory.velocity.end(), buffer + 2);
  buffer[5] = static_cast<double>(memory.bodies);
  buffer[6] = memory.axial;
  std::transform(first, last, buffer + kHead, [](const Pair& pair) { return static_cast<double>(pair.second); });
  return kHead + static_cast<std::size_t>(last - first);
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
