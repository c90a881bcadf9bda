#include "pbm_solver/model/class_grid.hpp"

#include <algorithm>
#include <cmath>

namespace granary::pbm {
namespace {

// With a ratio of 2 or 3 sums of pivots lie exactly on pivots and edges; round-off must not decide on which side.
constexpr double kOnEdge = 1e-12;

}  // namespace

SolidAxis::SolidAxis(int bins, double smallest, double ratio) {
  for (int i = 0; i < bins; ++i) pivot_.push_back(smallest * std::pow(ratio, i));
  edge_.push_back(0.0);
  for (int i = 1; i < bins; ++i) edge_.push_back(2.0 * pivot_[i] / (1.0 + ratio));
  edge_.push_back(pivot_.back());
  for (int i = 0; i < bins; ++i)
    for (int k = 0; k < bins; ++k) sum_cell_.push_back(cell(pivot_[i] + pivot_[k]));
  list_partners();
}

void SolidAxis::list_partners() {
  const int n = size();
  for (int i = 0; i < n; ++i) {
    const auto beyond = std::find(sum_cells(i), sum_cells(i) + n, n);
    highest_partner_.push_back(static_cast<int>(beyond - sum_cells(i)) - 1);
    for (int k = 0; k <= std::min(i, highest_partner_.back()); ++k)
      offsets_ = std::max(offsets_, sum_cell(i, k) - i + 1);
  }
  partners_.resize(static_cast<std::size_t>(offsets_ * n));
  for (int i = 0; i < n; ++i)
    for (int k = 0; k <= std::min(i, highest_partner_[i]); ++k) {
      PartnerRange& range = partners_[static_cast<std::size_t>((sum_cell(i, k) - i) * n + i)];
      if (range.empty()) range.first = k;
      range.last = k;
    }
}

int SolidAxis::cell(double v) const {
  if (v > pivot_.back() * (1.0 + kOnEdge)) return size();
  const auto above = std::upper_bound(edge_.begin() + 1, edge_.end() - 1, v * (1.0 + kOnEdge));
  return static_cast<int>(above - edge_.begin()) - 1;
}

PivotShare SolidAxis::share(int cell, double mean) const {
  const bool upwards = mean >= pivot(cell) && cell + 1 < size();
  const int lower = upwards ? cell : cell - 1;
  if (lower < 0 || size() == 1) return {0, 1.0, 0.0};
  const double to_upper = (mean - pivot(lower)) / (pivot(lower + 1) - pivot(lower));
  // A mean of round-off above the last pivot is on it.
  const double kept = std::clamp(to_upper, 0.0, 1.0);
  return {lower, 1.0 - kept, kept};
}

ClassGrid::ClassGrid(const Grid& grid)
    : axes_{SolidAxis(grid.bins[0], grid.smallest[0], grid.ratio[0]),
            SolidAxis(grid.bins[1], grid.smallest[1], grid.ratio[1])} {
  for (int i = 0; i < axes_[0].size(); ++i)
    for (int j = 0; j < axes_[1].size(); ++j) {
      solid_1_.push_back(axes_[0].pivot(i));
      solid_2_.push_back(axes_[1].pivot(j));
      solid_.push_back(axes_[0].pivot(i) + axes_[1].pivot(j));
    }
}

}  // namespace granary::pbm
