// The smallest value among the first n of many, with any of them changing: O(log) each.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

namespace granary::pilot {

class MinTree {
 public:
  static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();

  void set(int position, std::uint64_t value) {
    const auto at = static_cast<std::size_t>(position);
    if (at >= size_) {
      if (value == kNone) return;
      grow(at);
    }
    std::size_t node = size_ + at;
    values_[node] = value;
    while (node > 1) {
      node /= 2;
      const std::uint64_t smaller = std::min(values_[2 * node], values_[2 * node + 1]);
      if (values_[node] == smaller) return;  // nor do its parents change
      values_[node] = smaller;
    }
  }
  std::uint64_t at(int position) const {
    const auto at = static_cast<std::size_t>(position);
    return at < size_ ? values_[size_ + at] : kNone;
  }
  std::uint64_t smallest() const { return size_ == 0 ? kNone : values_[1]; }
  /// Of positions 0 .. last.
  std::uint64_t smallest_up_to(int last) const {
    if (size_ == 0 || last < 0) return kNone;
    if (static_cast<std::size_t>(last) + 1 >= size_ || values_[1] == kNone) return values_[1];
    std::uint64_t smallest = kNone;
    for (std::size_t end = size_ + static_cast<std::size_t>(last) + 1; end > 1; end /= 2) {
      if (end % 2 == 1) smallest = std::min(smallest, values_[end - 1]);
    }
    return smallest;
  }

 private:
  void grow(std::size_t at) {
    std::size_t size = std::max<std::size_t>(size_, 2);
    while (size <= at) size *= 2;
    std::vector<std::uint64_t> values(2 * size, kNone);
    for (std::size_t k = 0; k < size_; ++k) values[size + k] = values_[size_ + k];
    for (std::size_t node = size - 1; node >= 1; --node)
      values[node] = std::min(values[2 * node], values[2 * node + 1]);
    size_ = size;
    values_ = std::move(values);
  }

  std::size_t size_ = 0;               ///< a power of 2
  std::vector<std::uint64_t> values_;  ///< a heap: leaves from size_ on, each parent the smaller of its two children
};

}  // namespace granary::pilot
