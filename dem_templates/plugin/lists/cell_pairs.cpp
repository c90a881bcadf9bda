#include "dem_templates/plugin/lists/cell_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace granary::dem {
namespace {

constexpr double kMostCellsPerSphere = 16.0, kMostCellsMore = 1000.0;  // an empty cell costs little, but not nothing
constexpr std::uint32_t kAtOnce = 4;  // spheres of a row: where it ends can't be foreseen, but most hold no more

}  // namespace

void CellPairs::lay_out(const double* places, const double* radii, std::size_t n, double factor, double skin) {
  std::array<double, 3> high{};
  low_.fill(std::numeric_limits<double>::max());
  high.fill(std::numeric_limits<double>::lowest());
  double largest = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    largest = std::max(largest, radii[i]);
    for (std::size_t d = 0; d < 3; ++d) {
      const double x = places[3 * i + d];
      if (!std::isfinite(x)) continue;
      low_[d] = std::min(low_[d], x);
      high[d] = std::max(high[d], x);
    }
  }
  double size = 0.0;
  for (std::size_t d = 0; d < 3; ++d) {
    if (low_[d] > high[d]) low_[d] = high[d] = 0.0;
    size = std::max(size, high[d] - low_[d]);
  }
  const double reach = 2.0 * factor * largest + skin;
  skin_ = skin + 8.0 * std::numeric_limits<float>::epsilon() * (size + reach);  // of both places, rounded
  cell_size_ = std::max(reach + (skin_ - skin), std::numeric_limits<float>::min() + 1e-6 * size);
  for (double n_cells = 0.0;; cell_size_ *= 1.1) {
    n_cells = 1.0;
    for (std::size_t d = 0; d < 3; ++d) n_cells *= std::floor((high[d] - low_[d]) / cell_size_) + 3.0;
    if (n_cells > kMostCellsPerSphere * static_cast<double>(n) + kMostCellsMore) continue;
    for (std::size_t d = 0; d < 3; ++d) n_cells_[d] = static_cast<int>((high[d] - low_[d]) / cell_size_) + 3;
    break;
  }
}

void CellPairs::sort_by_cell(const double* places, const double* radii, std::size_t n, double factor) {
  const auto cell_along = [this](double x, std::size_t d) {
    const double cell = (x - low_[d]) / cell_size_, last = n_cells_[d] - 3.0;
    return cell > 0.0 ? 1 + static_cast<int>(std::min(cell, last)) : 1;  // what is no number: the first
  };
  first_.assign(static_cast<std::size_t>(n_cells_[0] * n_cells_[1] * n_cells_[2]) + 2, 0);
  cell_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double* at = places + 3 * i;
    cell_[i] = static_cast<std::uint32_t>((cell_along(at[2], 2) * n_cells_[1] + cell_along(at[1], 1)) * n_cells_[0] +
                                          cell_along(at[0], 0));
    ++first_[cell_[i] + 2];
  }
  for (std::size_t c = 2; c < first_.size(); ++c) first_[c] += first_[c - 1];
  for (std::vector<float>* of : {&x_, &y_, &z_, &reach_}) of->resize(n + kAtOnce);
  number_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t k = first_[cell_[i] + 1]++;  // in the end those of the next cell begin there
    x_[k] = static_cast<float>(places[3 * i] - low_[0]);
    y_[k] = static_cast<float>(places[3 * i + 1] - low_[1]);
    z_[k] = static_cast<float>(places[3 * i + 2] - low_[2]);
    reach_[k] = static_cast<float>(factor * radii[i]);
    number_[k] = static_cast<int>(i);
  }
}

// Without a branch on what is near: one in six is, and nobody can tell which.
inline void CellPairs::hold_against(std::uint32_t sphere, std::uint32_t first, std::uint32_t last) {
  if (near_.size() < n_near_ + (last - first) + kAtOnce) near_.resize(2 * (n_near_ + (last - first) + kAtOnce));
  std::uint32_t* const near = near_.data();
  std::size_t n = n_near_;
  const float x = x_[sphere], y = y_[sphere], z = z_[sphere], reach = reach_[sphere] + static_cast<float>(skin_);
  for (std::uint32_t k = first; k < last; k += kAtOnce) {
    std::array<bool, kAtOnce> is_near;
    for (std::uint32_t v = 0; v < kAtOnce; ++v) {
      const float dx = x - x_[k + v], dy = y - y_[k + v], dz = z - z_[k + v], apart = reach + reach_[k + v];
      is_near[v] = (dx * dx + dy * dy + dz * dz <= apart * apart) & (k + v < last);
    }
    for (std::uint32_t v = 0; v < kAtOnce; ++v) {
      near[n] = k + v;
      n += is_near[v] ? 1 : 0;
    }
  }
  n_near_ = n;
}

const std::vector<ListedPair>& CellPairs::find(const double* places, const double* radii, std::size_t n_own,
                                               std::size_t n, double factor, double skin) {
  pairs_.clear();
  if (n_own == 0) return pairs_;
  lay_out(places, radii, n, factor, skin);
  sort_by_cell(places, radii, n, factor);

  // Of the nine rows of three cells around a cell: what follows in its own, and the four that come later.
  const int row = n_cells_[0], layer = row * n_cells_[1];
  const std::array<int, 4> later{row, layer - row, layer, layer + row};
  for (std::uint32_t s = 0; s < n; ++s) {
    const int own = number_[s];
    const auto c = static_cast<int>(cell_[static_cast<std::size_t>(own)]);
    const auto begin = [this](int cell) { return first_[static_cast<std::size_t>(cell)]; };
    n_near_ = 0;
    hold_against(s, s + 1, begin(c + 2));
    for (const int to : later) hold_against(s, begin(c + to - 1), begin(c + to + 2));
    for (std::size_t k = 0; k < n_near_; ++k) {
      const auto [i, j] = std::minmax(own, number_[near_[k]]);
      if (static_cast<std::size_t>(i) < n_own) pairs_.push_back({i, j});
    }
  }
  return pairs_;
}

}  // namespace granary::dem
