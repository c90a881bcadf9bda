#include "dem_templates/plugin/lists/near_pairs.hpp"

#include <algorithm>
#include <cmath>

namespace granary::dem {
namespace {

// As LIGGGHTS works it out, to the last bit: both see the same pairs touch.
double distance2(const double* places, std::size_t i, std::size_t j) {
  const double *a = places + 3 * i, *b = places + 3 * j;
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

}  // namespace

void NearPairs::start(std::span<const Pair> pairs, const double* places, const double* radii, double widest) {
  drawer_width_ = std::max(widest, 1e-300) / static_cast<double>(kDrawers);
  rounding_ = 1e-9 * widest;
  first_.fill(0);
  drawer_.resize(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j, place] = pairs[k];
    const double gap = std::sqrt(distance2(places, i, j)) - radii[i] - radii[j];
    const double drawer = std::min(gap / drawer_width_, kDrawers - 1.0);
    drawer_[k] = drawer > 0.0 ? static_cast<std::uint8_t>(drawer) : std::uint8_t{0};
    ++first_[drawer_[k] + 1u];
  }
  for (std::size_t d = 1; d <= kDrawers; ++d) first_[d] += first_[d - 1];
  pairs_.resize(pairs.size());
  touching2_.resize(pairs.size());
  auto next = first_;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const double touching = radii[pairs[k].i] + radii[pairs[k].j];
    const std::size_t to = next[drawer_[k]]++;
    pairs_[to] = pairs[k];
    touching2_[to] = touching * touching;
  }
}

std::span<const std::uint32_t> NearPairs::touching(const double* places, double moved) {
  const double drawers = (2.0 * moved + rounding_) / drawer_width_;
  const std::size_t n_looked_at = drawers < kDrawers ? first_[static_cast<std::size_t>(drawers) + 1] : pairs_.size();
  if (touching_.size() < n_looked_at) touching_.resize(n_looked_at);
  std::size_t n = 0;
  for (std::size_t k = 0; k < n_looked_at; ++k) {  // which ones touch can't be foreseen: no branch
    touching_[n] = static_cast<std::uint32_t>(k);
    n += distance2(places, pairs_[k].i, pairs_[k].j) < touching2_[k] ? 1 : 0;
  }
  return {touching_.data(), n};
}

}  // namespace granary::dem
