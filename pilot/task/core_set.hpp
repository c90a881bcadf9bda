// Cores of the machine, by number, as stretches: what a task of 4096 ranks holds is some bytes and not 16 KiB.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace granary::pilot {

/// Keeps the order in which cores were added: a task's ranks go by it.
class CoreSet {
 public:
  struct Stretch {
    int first = 0, count = 0;
    bool operator==(const Stretch&) const = default;
  };

  CoreSet() = default;
  CoreSet(const std::vector<int>& cores);     // NOLINT: implicit on purpose, as below
  CoreSet(std::initializer_list<int> cores);  // NOLINT
  /// "0-3,8": what text() writes. Error: anything else.
  static Result<CoreSet> parse(std::string_view text);

  void add(int core) { add(core, 1); }
  /// `count` cores from `first` on.
  void add(int first, int count);
  bool empty() const { return first_.count == 0; }
  int size() const;
  int front() const { return first_.first; }
  std::vector<int> list() const;
  std::string text() const;
  bool operator==(const CoreSet&) const = default;

  template <class Fn>
  void for_each_stretch(Fn&& fn) const {
    if (!empty()) fn(first_);
    for (const Stretch& stretch : rest_) fn(stretch);
  }
  template <class Fn>
  void for_each(Fn&& fn) const {
    for_each_stretch([&](const Stretch& stretch) {
      for (int core = stretch.first; core < stretch.first + stretch.count; ++core) fn(core);
    });
  }

 private:
  void append(Stretch stretch);

  Stretch first_;              ///< most sets have no more
  std::vector<Stretch> rest_;  ///< in the order of adding
};

}  // namespace granary::pilot
