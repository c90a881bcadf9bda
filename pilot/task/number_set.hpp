// A set of small numbers, as bits: any change is O(1), the next one up is found in two steps of 64.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace granary::pilot {

class NumberSet {
 public:
  void insert(int number) {
    const std::size_t word = word_of(number);
    if (word >= words_.size()) {
      words_.resize(word + 1, 0);
      summary_.resize(word / 64 + 1, 0);
    }
    size_ += (words_[word] & bit_of(number)) == 0;
    words_[word] |= bit_of(number);
    summary_[word / 64] |= bit(word % 64);
  }
  void erase(int number) {
    const std::size_t word = word_of(number);
    if (word >= words_.size()) return;
    size_ -= (words_[word] & bit_of(number)) != 0;
    words_[word] &= ~bit_of(number);
    if (words_[word] == 0) summary_[word / 64] &= ~bit(word % 64);
  }
  bool has(int number) const {
    const std::size_t word = word_of(number);
    return word < words_.size() && (words_[word] & bit_of(number)) != 0;
  }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  /// The smallest that is not below `from`; -1: none.
  int next(int from) const {
    const std::size_t word = word_of(from);
    if (word >= words_.size()) return -1;
    const std::uint64_t here = words_[word] & ~(bit_of(from) - 1);
    if (here != 0) return static_cast<int>(word * 64) + std::countr_zero(here);
    std::uint64_t later = summary_[word / 64] & ~(bit(word % 64) | (bit(word % 64) - 1));
    for (std::size_t s = word / 64; s < summary_.size(); later = ++s < summary_.size() ? summary_[s] : 0) {
      if (later == 0) continue;
      const std::size_t found = s * 64 + static_cast<std::size_t>(std::countr_zero(later));
      return static_cast<int>(found * 64) + std::countr_zero(words_[found]);
    }
    return -1;
  }

 private:
  static std::uint64_t bit(std::size_t k) { return std::uint64_t{1} << k; }
  static std::size_t word_of(int number) { return static_cast<std::size_t>(number) / 64; }
  static std::uint64_t bit_of(int number) { return bit(static_cast<std::size_t>(number) % 64); }

  std::vector<std::uint64_t> words_, summary_;
  std::size_t size_ = 0;
};

}  // namespace granary::pilot
