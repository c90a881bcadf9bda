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

void CoreSet::add(int first, int count) {
  if (!stretches_.empty() && stretches_.back().first + stretches_.back().count == first) {
    stretches_.back().count += count;
  } else {
    if (stretches_.empty()) stretches_.reserve(1);
    stretches_.push_back({first, count});
  }
}

int CoreSet::size() const {
  int count = 0;
  for (const Stretch& stretch : stretches_) count += stretch.count;
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
  for (const Stretch& stretch : stretches_) {
    if (!text.empty()) text += ',';
    text += fmt::format_int(stretch.first).c_str();
    if (stretch.count == 1) continue;
    text += '-';
    text += fmt::format_int(stretch.first + stretch.count - 1).c_str();
  }
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
    cores.stretches_.push_back(stretch);
    at = read.ptr == end ? end : read.ptr + 1;
  }
  return cores;
}

}  // namespace granary::pilot
