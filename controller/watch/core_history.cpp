#include "controller/watch/core_history.hpp"

#include <algorithm>

namespace granary::watch {

namespace {
constexpr std::size_t kMostSlices = 480;
}

void CoreSeconds::add(const std::string& kind, double start, double end, int cores) {
  if (!(end > start) || start < 0.0 || cores <= 0) return;
  while (end >= slice_ * static_cast<double>(kMostSlices)) widen();
  auto found = std::find_if(seconds_.begin(), seconds_.end(), [&](const auto& one) { return one.first == kind; });
  if (found == seconds_.end()) found = seconds_.insert(seconds_.end(), {kind, {}});
  std::vector<double>& row = found->second;
  const auto last = static_cast<std::size_t>(end / slice_);
  if (row.size() <= last) row.resize(last + 1, 0.0);
  for (auto k = static_cast<std::size_t>(start / slice_); k <= last; ++k) {
    const double from = std::max(start, slice_ * static_cast<double>(k));
    const double to = std::min(end, slice_ * static_cast<double>(k + 1));
    row[k] += cores * std::max(0.0, to - from);
  }
}

void CoreSeconds::widen() {
  slice_ *= 2.0;
  for (auto& [kind, row] : seconds_) {
    std::vector<double> wide((row.size() + 1) / 2, 0.0);
    for (std::size_t k = 0; k < row.size(); ++k) wide[k / 2] += row[k];
    row = std::move(wide);
  }
}

CoreHistory CoreSeconds::history(double now) const {
  CoreHistory history{slice_, {}};
  std::size_t slices = 0;
  for (const auto& [kind, row] : seconds_) slices = std::max(slices, row.size());
  for (const auto& [kind, row] : seconds_) {
    std::vector<double> busy = row;
    busy.resize(slices, 0.0);
    for (std::size_t k = 0; k < slices; ++k) {
      const double length = std::min(slice_, now - slice_ * static_cast<double>(k));
      busy[k] = length > 1e-6 ? busy[k] / length : 0.0;
    }
    history.busy.emplace_back(kind, std::move(busy));
  }
  return history;
}

}  // namespace granary::watch
