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

std::vector<SizeRecord> records_of(const FragmentHistory& history, const std::vector<int>& bounds) {
  std::vector<SizeRecord> records;
  for (std::size_t c = 0; c + 1 < bounds.size(); ++c) records.push_back({bounds[c], bounds[c + 1] - 1, 0.0, 0.0, {}});
  const auto class_of = [&](int size) {
    return static_cast<std::size_t>(std::upper_bound(bounds.begin(), bounds.end(), size) - bounds.begin()) - 1;
  };
  const auto known = [&](int size) { return size >= bounds.front() && size < bounds.back(); };
  std::vector<double> at_start(records.size(), 0.0);  // fragments times time, as if none were split
  std::vector<double> began(records.size(), 0.0);     // fragments that were there at the start of an interval
  for (std::size_t i = 1; i < history.size(); ++i) {
    const double dt = history[i].time - history[i - 1].time;
    for (const auto& [size, n] : history[i - 1].alive) {
      if (!known(size)) continue;
      at_start[class_of(size)] += static_cast<double>(n) * dt;
      began[class_of(size)] += static_cast<double>(n);
      records[class_of(size)].mean_size += static_cast<double>(n) * dt * size;
    }
    for (const Split& split : history[i].splits)
      if (known(split.parent)) ++records[class_of(split.parent)].splits[split.cause];
  }
  for (std::size_t c = 0; c < records.size(); ++c) {
    SizeRecord& record = records[c];
    record.mean_size = at_start[c] > 0.0 ? record.mean_size / at_start[c] : 0.5 * (record.from + record.to);
    const double share = began[c] > 0.0 ? static_cast<double>(record.all_splits()) / began[c] : 0.0;
    // Where all are split within one interval the rate is unbounded: half of one that would not have been is assumed.
    const double bounded = std::min(share, 1.0 - 0.5 / std::max(1.0, began[c]));
    record.exposure = bounded > 0.0 ? at_start[c] * bounded / -std::log1p(-bounded) : at_start[c];
  }
  return records;
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
