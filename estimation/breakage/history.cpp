#include "estimation/breakage/history.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace granary::estimation {
namespace {

Result<Split> split_of(const json::Value& line, const std::string& place) {
  Split split;
  split.parent = static_cast<int>(line.integer_or("parent", 0));
  for (const double spheres : line.numbers("daughters")) split.daughters.push_back(static_cast<int>(spheres));
  split.cause = line.text_or("cause", "none");
  split.agglomerate = static_cast<int>(line.integer_or("agglomerate", 0));
  const int sum = std::accumulate(split.daughters.begin(), split.daughters.end(), 0);
  if (split.daughters.size() < 2 || sum != split.parent)
    return Error{fmt::format("{}: a fragment of {} spheres is split into {} pieces of {} spheres together.", place,
                             split.parent, split.daughters.size(), sum)};
  return split;
}

}  // namespace

long SizeRecord::all_splits() const {
  long sum = 0;
  for (const auto& [cause, n] : splits) sum += n;
  return sum;
}

Result<FragmentHistory> history_of(const std::vector<json::Value>& lines, const std::string& file) {
  FragmentHistory history;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string place = fmt::format("{}: line {}", file, i + 1);
    FragmentSample sample;
    if (!lines[i]["time_s"].is_number() || !lines[i]["sizes"].is_array())
      return Error{place + ": this is no sample of fragments (no time_s, or no sizes)."};
    sample.time = lines[i]["time_s"].as_number();
    if (!history.empty() && !(sample.time > history.back().time)) return Error{place + ": its time does not rise."};
    for (const json::Value& pair : lines[i]["sizes"].items()) {
      const auto numbers = pair.numbers();
      if (numbers.size() != 2) return Error{place + ": sizes must be pairs [spheres, count]."};
      sample.alive[static_cast<int>(numbers[0])] += static_cast<long>(numbers[1]);
    }
    for (const json::Value& written : lines[i]["splits"].items_or_none()) {
      GRANARY_TRY(Split split, split_of(written, place));
      sample.splits.push_back(std::move(split));
    }
    history.push_back(std::move(sample));
  }
  return history;
}

void SizeSums::add(const SizeSums& other, long times) {
  const auto n = static_cast<double>(times);
  time += n * other.time;
  size_time += n * other.size_time;
  began += n * other.began;
  for (const auto& [cause, count] : other.splits) splits[cause] += times * count;
}

std::vector<SizeSums> sums_of(const FragmentHistory& history, const std::vector<int>& bounds) {
  std::vector<SizeSums> sums(bounds.empty() ? 0 : bounds.size() - 1);
  const auto sums_for = [&](int size) -> SizeSums* {
    if (size < bounds.front() || size >= bounds.back()) return nullptr;
    return &sums[static_cast<std::size_t>(std::upper_bound(bounds.begin(), bounds.end(), size) - bounds.begin()) - 1];
  };
  for (std::size_t i = 1; i < history.size(); ++i) {
    const double dt = history[i].time - history[i - 1].time;
    for (const auto& [size, n] : history[i - 1].alive)
      if (SizeSums* one = sums_for(size)) {
        one->time += static_cast<double>(n) * dt;
        one->size_time += static_cast<double>(n) * dt * size;
        one->began += static_cast<double>(n);
      }
    for (const Split& split : history[i].splits)
      if (SizeSums* one = sums_for(split.parent)) ++one->splits[split.cause];
  }
  return sums;
}

std::vector<SizeRecord> records_of(const std::vector<SizeSums>& sums, const std::vector<int>& bounds) {
  std::vector<SizeRecord> records;
  for (std::size_t c = 0; c < sums.size(); ++c) {
    const SizeSums& sum = sums[c];
    SizeRecord record{bounds[c], bounds[c + 1] - 1, 0.0, 0.0, sum.splits};
    record.mean_size = sum.time > 0.0 ? sum.size_time / sum.time : 0.5 * (record.from + record.to);
    const double share = sum.began > 0.0 ? static_cast<double>(record.all_splits()) / sum.began : 0.0;
    // Where all are split within one interval the rate is unbounded: half of one that would not have been is assumed.
    const double bounded = std::min(share, 1.0 - 0.5 / std::max(1.0, sum.began));
    record.exposure = bounded > 0.0 ? sum.time * bounded / -std::log1p(-bounded) : sum.time;
    records.push_back(std::move(record));
  }
  return records;
}

std::vector<SizeRecord> records_of(const FragmentHistory& history, const std::vector<int>& bounds) {
  return records_of(sums_of(history, bounds), bounds);
}

std::vector<FragmentHistory> by_agglomerate(const FragmentHistory& history, int whole) {
  if (history.empty()) return {};
  const auto& first = history.front().alive;
  if (first.size() != 1 || first.begin()->first != whole) return {};
  const auto n = static_cast<std::size_t>(first.begin()->second);
  std::vector<FragmentHistory> all(n, FragmentHistory{{history.front().time, {{whole, 1}}, {}}});
  for (std::size_t i = 1; i < history.size(); ++i) {
    for (FragmentHistory& one : all) one.push_back({history[i].time, one.back().alive, {}});
    for (const Split& split : history[i].splits) {
      const auto at = static_cast<std::size_t>(split.agglomerate) - 1;
      if (at >= n) return {};
      FragmentSample& sample = all[at].back();
      if (--sample.alive[split.parent] <= 0) sample.alive.erase(split.parent);
      for (const int daughter : split.daughters) ++sample.alive[daughter];
      sample.splits.push_back(split);
    }
  }
  return all;
}

std::vector<int> size_bounds(int largest) {
  std::vector<int> bounds;
  for (int size = 2; size < largest; size = std::max(size + 1, static_cast<int>(std::lround(1.2 * size))))
    bounds.push_back(size);
  if (largest > 1) bounds.push_back(largest);
  bounds.push_back(largest + 1);
  return bounds;
}

}  // namespace granary::estimation
