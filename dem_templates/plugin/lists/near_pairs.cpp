#include "dem_templates/plugin/lists/near_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace granary::dem {
namespace {

constexpr double kNearly = 1.0 + 1e-12;  // who asks may round otherwise

double distance2(const double* places, std::size_t i, std::size_t j) {
  const double *a = places + 3 * i, *b = places + 3 * j;
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

}  // namespace

void NearPairs::start(std::span<const ListedPair> pairs, const double* places, const double* radii, std::size_t n,
                      double widest) {
  is_touching_.assign((n + 7) / 8 * 8, 0);
  drawer_width_ = std::max(widest, 1e-300) / static_cast<double>(kDrawers);
  rounding_ = 1e-9 * widest;
  first_.fill(0);
  drawer_.resize(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j] = pairs[k];
    const double gap =
        std::sqrt(distance2(places, static_cast<std::size_t>(i), static_cast<std::size_t>(j))) - radii[i] - radii[j];
    const double drawer = std::min(gap / drawer_width_, kDrawers - 1.0);
    drawer_[k] = drawer > 0.0 ? static_cast<std::uint8_t>(drawer) : std::uint8_t{0};
    ++first_[drawer_[k] + 1u];
  }
  for (std::size_t d = 1; d <= kDrawers; ++d) first_[d] += first_[d - 1];
  pairs_.resize(pairs.size());
  auto next = first_;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j] = pairs[k];
    const double touching = radii[i] + radii[j];
    pairs_[next[drawer_[k]]++] = {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j),
                                  kNearly * touching * touching};
  }
}

std::vector<int>& NearPairs::touching(const double* places, double moved) {
  const double drawers = (2.0 * moved + rounding_) / drawer_width_;
  const std::size_t n_looked_at = drawers < kDrawers ? first_[static_cast<std::size_t>(drawers) + 1] : pairs_.size();
  for (std::size_t k = 0; k < n_looked_at; ++k) {
    const auto [i, j, touching2] = pairs_[k];
    if (distance2(places, i, j) < touching2) is_touching_[i] = 1;
  }
  touching_.clear();
  for (std::size_t i = 0; i < is_touching_.size(); i += 8) {
    std::uint64_t any = 0;
    std::memcpy(&any, &is_touching_[i], sizeof any);
    if (any == 0) continue;
    for (std::size_t k = i; k < i + 8; ++k)
      if (is_touching_[k] != 0) touching_.push_back(static_cast<int>(k));
    std::memset(&is_touching_[i], 0, 8);
  }
  return touching_;
}

}  // namespace granary::dem
