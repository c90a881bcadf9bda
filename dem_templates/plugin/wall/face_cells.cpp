#include "dem_templates/plugin/wall/face_cells.hpp"

#include <algorithm>
#include <cmath>

#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {
namespace {

constexpr double kMostCells = 2e5;
constexpr double kRoundDown = 1.0 - 1e-6;

}  // namespace

FaceCells::FaceCells(std::span<const Face> faces, double reach) : margin_(reach) {
  low_ = high_ = faces[0].corner[0];
  for (const Face& face : faces) {
    for (const Vector3& corner : face.corner) {
      for (std::size_t d = 0; d < 3; ++d) {
        low_[d] = std::min(low_[d], corner[d] - reach);
        high_[d] = std::max(high_[d], corner[d] + reach);
      }
    }
  }
  const Vector3 size = high_ - low_;
  cell_size_ = std::max(0.5 * reach, std::cbrt(size[0] * size[1] * size[2] / kMostCells));
  for (std::size_t d = 0; d < 3; ++d) n_cells_[d] = static_cast<long>(size[d] / cell_size_) + 1;
  list(faces, reach);
  measure_empty_cells();
}

Vector3 FaceCells::middle(long i, long j, long k) const {
  return low_ +
         cell_size_ * Vector3{static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5, static_cast<double>(k) + 0.5};
}

template <class WithCell>
void FaceCells::for_cells_near(const Face& face, double widened, WithCell&& with_cell) const {
  std::array<long, 3> first{}, last{};
  for (std::size_t d = 0; d < 3; ++d) {
    const auto [least, most] =
        std::minmax({face.corner[0][d], face.corner[1][d], face.corner[2][d], face.corner[3][d]});
    first[d] = std::max(0L, static_cast<long>((least - widened - low_[d]) / cell_size_));
    last[d] = std::min(n_cells_[d] - 1, static_cast<long>((most + widened - low_[d]) / cell_size_));
  }
  for (long i = first[0]; i <= last[0]; ++i)
    for (long j = first[1]; j <= last[1]; ++j)
      for (long k = first[2]; k <= last[2]; ++k) with_cell(index(i, j, k), middle(i, j, k));
}

// A face goes into each cell that has a point nearer to it than the reach.
void FaceCells::list(std::span<const Face> faces, double reach) {
  const double half_diagonal = 0.5 * std::sqrt(3.0) * cell_size_, listed = half_diagonal + reach;
  struct Pair {
    std::size_t cell;
    NearPart entry;
  };
  std::vector<Pair> pairs;
  for (std::size_t t = 0; t < faces.size(); ++t) {
    const Face& face = faces[t];
    const Vector3 area = cross(face.corner[1] - face.corner[0], face.corner[2] - face.corner[0]);
    const Vector3 normal = (1.0 / norm(area)) * area;
    for_cells_near(face, listed, [&](std::size_t cell, const Vector3& at) {
      if (std::abs(dot(at - face.corner[0], normal)) > listed) return;  // most cells of a slanted face's box
      const double distance = norm(at - nearest_point(face, at));
      if (distance > listed) return;
      pairs.push_back({cell, {static_cast<std::uint32_t>(t), static_cast<float>(kRoundDown * distance)}});
    });
  }
  const auto n_cells = static_cast<std::size_t>(n_cells_[0] * n_cells_[1] * n_cells_[2]);
  cells_.assign(n_cells + 1, {static_cast<float>(kRoundDown * listed), 0});
  for (const Pair& pair : pairs) ++cells_[pair.cell + 1].first;
  for (std::size_t c = 1; c <= n_cells; ++c) cells_[c].first += cells_[c - 1].first;
  entries_.resize(pairs.size());
  std::vector<std::uint32_t> next(n_cells);
  for (std::size_t c = 0; c < n_cells; ++c) next[c] = cells_[c].first;
  for (const Pair& pair : pairs) entries_[next[pair.cell]++] = pair.entry;
  for (std::size_t c = 0; c < n_cells; ++c)
    std::sort(entries_.begin() + cells_[c].first, entries_.begin() + cells_[c + 1].first,
              [](const NearPart& a, const NearPart& b) { return a.distance < b.distance; });
}

// How far an empty cell is from the surface: so many cells, along the axis on which it is most, from the nearest cell
// that the surface may run through. In two sweeps over the grid, as chamfer distances are found (G. Borgefors,
// Distance transformations in digital images, 1986).
void FaceCells::measure_empty_cells() {
  const auto far = static_cast<std::uint16_t>(std::min(65000L, n_cells_[0] + n_cells_[1] + n_cells_[2]));
  std::vector<std::uint16_t> steps(cells_.size() - 1, far);
  const double half_diagonal = 0.5 * std::sqrt(3.0) * cell_size_;
  for (std::size_t c = 0; c + 1 < cells_.size(); ++c) {
    const std::uint32_t first = cells_[c].first;
    if (first < cells_[c + 1].first && entries_[first].distance <= half_diagonal) steps[c] = 0;
  }
  const auto sweep = [&](long sign) {
    const auto from = [&](std::size_t d) { return sign > 0 ? 0L : n_cells_[d] - 1; };
    for (long i = from(0); i >= 0 && i < n_cells_[0]; i += sign) {
      for (long j = from(1); j >= 0 && j < n_cells_[1]; j += sign) {
        for (long k = from(2); k >= 0 && k < n_cells_[2]; k += sign) {
          std::uint16_t& here = steps[index(i, j, k)];
          if (here == 0) continue;
          int least = here;
          // The half of the neighbours that the sweep has been to.
          for (long a = -1; a <= 0; ++a) {
            for (long b = -1; b <= (a < 0 ? 1 : 0); ++b) {
              for (long c = -1; c <= (a < 0 || b < 0 ? 1 : -1); ++c) {
                const long ni = i + sign * a, nj = j + sign * b, nk = k + sign * c;
                if (ni < 0 || nj < 0 || nk < 0 || ni >= n_cells_[0] || nj >= n_cells_[1] || nk >= n_cells_[2]) continue;
                least = std::min(least, steps[index(ni, nj, nk)] + 1);
              }
            }
          }
          here = static_cast<std::uint16_t>(least);
        }
      }
    }
  };
  sweep(1);
  sweep(-1);
  for (std::size_t c = 0; c + 1 < cells_.size(); ++c)
    cells_[c].clear = std::max(cells_[c].clear, static_cast<float>((steps[c] - 0.5) * cell_size_ * kRoundDown));
}

bool FaceCells::inside(const Vector3& point) const {
  for (std::size_t d = 0; d < 3; ++d)
    if (!(point[d] > low_[d] && point[d] < high_[d])) return false;
  return true;
}

std::array<long, 3> FaceCells::cell_of(const Vector3& point) const {
  std::array<long, 3> cell{};
  for (std::size_t d = 0; d < 3; ++d) cell[d] = static_cast<long>((point[d] - low_[d]) / cell_size_);
  return cell;
}

void FaceCells::fetch(const Vector3& point) const {
  if (!inside(point)) return;
  const auto [i, j, k] = cell_of(point);
  __builtin_prefetch(&cells_[index(i, j, k)]);
}

FaceCells::Near FaceCells::near(const Vector3& point) const {
  if (!inside(point)) {
    double outside = 0.0;
    for (std::size_t e = 0; e < 3; ++e)
      outside = std::max({outside, low_[e] + margin_ - point[e], point[e] - high_[e] + margin_});
    return {outside, 0.0, {}};
  }
  const std::array<long, 3> cell = cell_of(point);
  const std::size_t c = index(cell[0], cell[1], cell[2]);
  const double off_middle = norm(point - middle(cell[0], cell[1], cell[2]));
  return {static_cast<double>(cells_[c].clear) - off_middle, off_middle,
          std::span(entries_).subspan(cells_[c].first, cells_[c + 1].first - cells_[c].first)};
}

}  // namespace granary::dem
