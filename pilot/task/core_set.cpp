#include "pilot/task/core_set.hpp"

#include <fmt/format.h>

#include <charconv>

namespace granary::pilot {

CoreSet::CoreSet(const std::vector<int>& cores) {
  for (const int core : cores) add(core);
}

CoreSet::CoreSet(std::initializer_list<int> cores) {
  for (const int core : cores) add(core);
}

void CoreSet::append(Stretch stretch) {
  if (empty()) {
    first_ = stretch;
  } else {
    rest_.push_back(stretch);
  }
}

void CoreSet::add(int first, int count) {
  Stretch& last = rest_.empty() ? first_ : rest_.back();
  if (!empty() && last.first + last.count == first) {
    last.count += count;
  } else if (count > 0) {
    append({first, count});
  }
}

int CoreSet::size() const {
  int count = 0;
  for_each_stretch([&](const Stretch& stretch) { count += stretch.count; });
  return count;
}

std::vector<int> CoreSet::list() const {
  std::vector<int> cores;
  cores.reserve(static_cast<std::size_t>(size()));
  for_each([&](int core) { cores.push_back(core); });
  return cores;
}

std::string CoreSet::text() const {
  std::string text;
  for_each_stretch([&](const Stretch& stretch) {
    if (!text.empty()) text += ',';
    text += fmt::format_int(stretch.first).c_str();
    if (stretch.count == 1) return;
    text += '-';
    text += fmt::format_int(stretch.first + stretch.count - 1).c_str();
  });
  return text;
}

Result<CoreSet> CoreSet::parse(std::string_view text) {
  CoreSet cores;
  const char *at = text.data(), *end = at + text.size();
  while (at != end) {
    Stretch stretch{0, 1};
    auto read = std::from_chars(at, end, stretch.first);
    bool good = read.ec == std::errc() && stretch.first >= 0;
    if (good && read.ptr != end && *read.ptr == '-') {
      int last = -1;
      read = std::from_chars(read.ptr + 1, end, last);
      good = read.ec == std::errc() && last >= stretch.first && last < 100'000'000;
      stretch.count = good ? last - stretch.first + 1 : 0;
    }
    if (!good || (read.ptr != end && *read.ptr != ',')) {
      return Error{fmt::format("\"{}\" is no list of cores such as \"0-3,8\"", text)};
    }
    cores.append(stretch);
    at = read.ptr == end ? end : read.ptr + 1;
  }
  return cores;
}

}  // namespace granary::pilot
