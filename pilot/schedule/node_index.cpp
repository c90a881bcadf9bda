#include "pilot/schedule/node_index.hpp"

#include <bit>

namespace granary::pilot {
namespace {

std::size_t word_of(int number) { return static_cast<std::size_t>(number) / 64; }
std::uint64_t bit_of(std::size_t number) { return std::uint64_t{1} << (number % 64); }
std::uint64_t bit_of(int number) { return bit_of(static_cast<std::size_t>(number)); }

}  // namespace

void BitSet::insert(int number) {
  const std::size_t word = word_of(number);
  if (word >= words_.size()) {
    words_.resize(word + 1, 0);
    summary_.resize(word / 64 + 1, 0);
  }
  words_[word] |= bit_of(number);
  summary_[word / 64] |= bit_of(word);
}

void BitSet::erase(int number) {
  const std::size_t word = word_of(number);
  if (word >= words_.size()) return;
  words_[word] &= ~bit_of(number);
  if (words_[word] == 0) summary_[word / 64] &= ~bit_of(word);
}

int BitSet::next(int from) const {
  const std::size_t word = word_of(from);
  if (word >= words_.size()) return -1;
  const std::uint64_t here = words_[word] & ~(bit_of(from) - 1);
  if (here != 0) return static_cast<int>(word * 64) + std::countr_zero(here);
  std::uint64_t later = summary_[word / 64] & ~(bit_of(word) | (bit_of(word) - 1));
  for (std::size_t s = word / 64; s < summary_.size(); later = ++s < summary_.size() ? summary_[s] : 0) {
    if (later == 0) continue;
    const std::size_t found = s * 64 + static_cast<std::size_t>(std::countr_zero(later));
    return static_cast<int>(found * 64) + std::countr_zero(words_[found]);
  }
  return -1;
}

NodeIndex::NodeIndex(int n_nodes, int largest)
    : count_(static_cast<std::size_t>(n_nodes), 0),
      nodes_(static_cast<std::size_t>(largest) + 1),
      at_least_(static_cast<std::size_t>(largest) + 1, 0) {
  for (int node = 0; node < n_nodes; ++node) nodes_[0].insert(node);
  at_least_[0] = n_nodes;
}

void NodeIndex::set(int node, int count) {
  int& now = count_[static_cast<std::size_t>(node)];
  if (now == count) return;
  nodes_[static_cast<std::size_t>(now)].erase(node);
  nodes_[static_cast<std::size_t>(count)].insert(node);
  for (int c = now + 1; c <= count; ++c) ++at_least_[static_cast<std::size_t>(c)];
  for (int c = count + 1; c <= now; ++c) --at_least_[static_cast<std::size_t>(c)];
  now = count;
}

}  // namespace granary::pilot
