#include "dem_templates/plugin/resize/triangles.hpp"

#include <algorithm>
#include <cmath>

namespace granary::dem {
namespace {

constexpr double kRoundUp = 1.0 + 1e-9;

}  // namespace

Vector3 unit_normal(const Triangle& triangle) {
  const Vector3 area = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
  const double size = norm(area);
  return size > 0.0 ? (1.0 / size) * area : Vector3{};
}

Vector3 nearest_point(const Triangle& triangle, const Vector3& p) {
  const auto& [a, b, c] = triangle;
  const Vector3 ab = b - a, ac = c - a;

  const Vector3 ap = p - a;
  const double ab_ap = dot(ab, ap), ac_ap = dot(ac, ap);
  if (ab_ap <= 0.0 && ac_ap <= 0.0) return a;

  const Vector3 bp = p - b;
  const double ab_bp = dot(ab, bp), ac_bp = dot(ac, bp);
  if (ab_bp >= 0.0 && ac_bp <= ab_bp) return b;

  const Vector3 cp = p - c;
  const double ab_cp = dot(ab, cp), ac_cp = dot(ac, cp);
  if (ac_cp >= 0.0 && ab_cp <= ac_cp) return c;

  const double over_ab = ab_ap * ac_bp - ab_bp * ac_ap;
  if (over_ab <= 0.0 && ab_ap >= 0.0 && ab_bp <= 0.0) return a + (ab_ap / (ab_ap - ab_bp)) * ab;
  const double over_ac = ab_cp * ac_ap - ab_ap * ac_cp;
  if (over_ac <= 0.0 && ac_ap >= 0.0 && ac_cp <= 0.0) return a + (ac_ap / (ac_ap - ac_cp)) * ac;
  const double over_bc = ab_bp * ac_cp - ab_cp * ac_bp;
  const double from_b = ac_bp - ab_bp, from_c = ab_cp - ac_cp;
  if (over_bc <= 0.0 && from_b >= 0.0 && from_c >= 0.0) return b + (from_b / (from_b + from_c)) * (c - b);

  const double whole = over_ab + over_ac + over_bc;
  return a + (over_ac / whole) * ab + (over_ab / whole) * ac;
}

Triangles::Triangles(std::vector<Triangle> triangles, double reach) : triangles_(std::move(triangles)) {
  if (triangles_.empty()) return;
  Vector3 high = low_ = triangles_[0][0];
  for (const Triangle& triangle : triangles_) {
    normals_.push_back(unit_normal(triangle));
    for (const Vector3& corner : triangle) {
      for (std::size_t d = 0; d < 3; ++d) {
        low_[d] = std::min(low_[d], corner[d] - reach);
        high[d] = std::max(high[d], corner[d] + reach);
      }
    }
  }
  // About a hundred cells along the longest side at most: building must not cost more than asking.
  cell_size_ = std::max(2.0 * reach, std::max({high[0] - low_[0], high[1] - low_[1], high[2] - low_[2]}) / 100.0);
  for (std::size_t d = 0; d < 3; ++d) n_cells_[d] = static_cast<long>((high[d] - low_[d]) / cell_size_) + 1;
  cells_.resize(static_cast<std::size_t>(n_cells_[0] * n_cells_[1] * n_cells_[2]));

  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    std::array<long, 3> first{}, last{};
    for (int d = 0; d < 3; ++d) {
      const auto [least, most] =
          std::minmax({triangles_[t][0][static_cast<std::size_t>(d)], triangles_[t][1][static_cast<std::size_t>(d)],
                       triangles_[t][2][static_cast<std::size_t>(d)]});
      first[static_cast<std::size_t>(d)] = std::max(0L, cell_of(least - reach, d));
      last[static_cast<std::size_t>(d)] = std::min(n_cells_[static_cast<std::size_t>(d)] - 1, cell_of(most + reach, d));
    }
    // A large slanted triangle fills a box of which it meets few cells: take those it comes near.
    const double half_diagonal = 0.5 * std::sqrt(3.0) * cell_size_;
    for (long i = first[0]; i <= last[0]; ++i) {
      for (long j = first[1]; j <= last[1]; ++j) {
        for (long k = first[2]; k <= last[2]; ++k) {
          const Vector3 centre = low_ + cell_size_ * Vector3{static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5,
                                                             static_cast<double>(k) + 0.5};
          if (plane_is_beyond(t, centre, half_diagonal + reach)) continue;
          if (norm(centre - nearest_point(triangles_[t], centre)) <= half_diagonal + reach)
            cells_[index(i, j, k)].push_back(static_cast<int>(t));
        }
      }
    }
  }
}

void Triangles::near(const Vector3& point, double reach, std::vector<NearWall>& found) const {
  std::array<long, 3> cell{};
  for (int d = 0; d < 3; ++d) {
    const auto axis = static_cast<std::size_t>(d);
    cell[axis] = cell_of(point[axis], d);
    if (cell[axis] < 0 || cell[axis] >= n_cells_[axis]) return;
  }
  for (const int listed : cells_[index(cell[0], cell[1], cell[2])]) {
    const auto t = static_cast<std::size_t>(listed);
    if (plane_is_beyond(t, point, reach)) continue;
    const Vector3 away = point - nearest_point(triangles_[t], point);
    const double distance = norm(away);
    if (distance < reach && distance > 0.0) found.push_back({distance, (1.0 / distance) * away});
  }
}

bool Triangles::plane_is_beyond(std::size_t triangle, const Vector3& point, double reach) const {
  return std::abs(dot(point - triangles_[triangle][0], normals_[triangle])) > kRoundUp * reach;
}

long Triangles::cell_of(double coordinate, int axis) const {
  return static_cast<long>(std::floor((coordinate - low_[static_cast<std::size_t>(axis)]) / cell_size_));
}

std::size_t Triangles::index(long i, long j, long k) const {
  return static_cast<std::size_t>((i * n_cells_[1] + j) * n_cells_[2] + k);
}

}  // namespace granary::dem
