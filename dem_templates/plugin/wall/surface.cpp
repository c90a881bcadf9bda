#include "dem_templates/plugin/wall/surface.hpp"

#include <algorithm>
#include <cmath>

namespace granary::dem {
namespace {

constexpr double kMostCells = 5e5;
constexpr double kReach = 2.0;  // of the largest radius: a farther look costs more, but lasts longer

// Towards the centre; where the centre lies in the surface, the surface's own normal.
SurfaceTouch touch_from(const Vector3& centre, const Vector3& point, double distance, const Vector3& own_normal) {
  const bool apart = distance > 1e-14;
  return {distance, point, apart ? (1.0 / distance) * (centre - point) : own_normal};
}

}  // namespace

double PlaneSurface::touches(const Vector3& centre, double radius, Nearby&, std::vector<SurfaceTouch>& found) {
  found.clear();
  const double height = dot(centre - point_, normal_);
  if (std::abs(height) < radius)
    found.push_back({std::abs(height), centre - height * normal_, (height < 0.0 ? -1.0 : 1.0) * normal_});
  return std::abs(height);
}

double CylinderSurface::touches(const Vector3& centre, double radius, Nearby&, std::vector<SurfaceTouch>& found) {
  found.clear();
  const Vector3 from_point = centre - point_;
  const Vector3 outwards = from_point - dot(from_point, axis_) * axis_;
  const double off_axis = norm(outwards), height = off_axis - radius_;
  if (std::abs(height) >= radius || off_axis == 0.0) return std::abs(height);
  const Vector3 away = (1.0 / off_axis) * outwards;
  found.push_back({std::abs(height), centre - height * away, (height < 0.0 ? -1.0 : 1.0) * away});
  return std::abs(height);
}

MeshSurface::MeshSurface(std::vector<Triangle> triangles, double smooth)
    : triangles_(std::move(triangles)), same_direction_(std::cos(smooth)) {
  Vector3 low = triangles_[0][0], high = low;
  for (const Triangle& triangle : triangles_) {
    const auto& [a, b, c] = triangle;
    const Vector3 ab = b - a, ac = c - a, area = cross(ab, ac);
    const double bb = dot(ab, ab), bc = dot(ab, ac), cc = dot(ac, ac), whole = bb * cc - bc * bc;
    const Vector3 normal = (1.0 / norm(area)) * area;
    const Vector3 to_b = (1.0 / whole) * (cc * ab - bc * ac), to_c = (1.0 / whole) * (bb * ac - bc * ab);
    planes_.push_back({normal, dot(normal, a)});
    faces_.push_back(
        {to_b, to_c, dot(to_b, a), dot(to_c, a), {1.0 / norm(to_b + to_c), 1.0 / norm(to_b), 1.0 / norm(to_c)}});
    for (const Vector3& corner : triangle) {
      for (std::size_t d = 0; d < 3; ++d) {
        low[d] = std::min(low[d], corner[d]);
        high[d] = std::max(high[d], corner[d]);
      }
    }
  }
  same_point_ = 1e-6 * norm(high - low);
}

double MeshSurface::farthest_from(const Vector3& origin, const Vector3& unit_axis) const {
  double farthest = 0.0;
  for (const Triangle& triangle : triangles_)
    for (const Vector3& corner : triangle) farthest = std::max(farthest, norm(cross(unit_axis, corner - origin)));
  return farthest;
}

// Cells are half as wide as the reach, or wider where the body has more room than memory should go to. In each the
// triangles that come nearer to some point of it than the reach.
void MeshSurface::build_cells(double reach) {
  reach_ = reach;
  low_ = triangles_[0][0];
  Vector3 high = low_;
  for (const Triangle& triangle : triangles_) {
    for (const Vector3& corner : triangle) {
      for (std::size_t d = 0; d < 3; ++d) {
        low_[d] = std::min(low_[d], corner[d] - reach);
        high[d] = std::max(high[d], corner[d] + reach);
      }
    }
  }
  const Vector3 size = high - low_;
  cell_size_ = std::max(0.5 * reach, std::cbrt(size[0] * size[1] * size[2] / kMostCells));
  for (std::size_t d = 0; d < 3; ++d) n_cells_[d] = static_cast<long>(size[d] / cell_size_) + 1;

  const double half_diagonal = 0.5 * std::sqrt(3.0) * cell_size_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // cell, triangle
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const Triangle& triangle = triangles_[t];
    std::array<long, 3> first{}, last{};
    for (std::size_t d = 0; d < 3; ++d) {
      const auto [least, most] = std::minmax({triangle[0][d], triangle[1][d], triangle[2][d]});
      first[d] = std::max(0L, static_cast<long>((least - reach - low_[d]) / cell_size_));
      last[d] = std::min(n_cells_[d] - 1, static_cast<long>((most + reach - low_[d]) / cell_size_));
    }
    for (long i = first[0]; i <= last[0]; ++i) {
      for (long j = first[1]; j <= last[1]; ++j) {
        for (long k = first[2]; k <= last[2]; ++k) {
          const Vector3 middle = low_ + cell_size_ * Vector3{static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5,
                                                             static_cast<double>(k) + 0.5};
          if (std::abs(dot(middle, planes_[t].normal) - planes_[t].offset) > half_diagonal + reach) continue;
          if (norm(middle - nearest_point(triangle, middle)) <= half_diagonal + reach)
            pairs.emplace_back(cell_index(i, j, k), t);
        }
      }
    }
  }
  first_.assign(static_cast<std::size_t>(n_cells_[0] * n_cells_[1] * n_cells_[2]) + 1, 0);
  for (const auto& [cell, triangle] : pairs) ++first_[cell + 1];
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  entries_.resize(pairs.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (const auto& [cell, triangle] : pairs) entries_[next[cell]++] = triangle;
}

// A lower bound of the squared distance: to the plane, and to the farthest side's line that the point is beyond of.
double MeshSurface::least_distance2(std::uint32_t t, const Vector3& point) const {
  const double height = dot(point, planes_[t].normal) - planes_[t].offset;
  const Face& face = faces_[t];
  const double of_b = dot(point, face.to_b) - face.b, of_c = dot(point, face.to_c) - face.c, of_a = 1.0 - of_b - of_c;
  const double beyond = std::max({0.0, -of_a * face.heights[0], -of_b * face.heights[1], -of_c * face.heights[2]});
  return height * height + beyond * beyond;
}

std::span<const std::uint32_t> MeshSurface::cell_at(const Vector3& centre) const {
  std::array<long, 3> cell{};
  for (std::size_t d = 0; d < 3; ++d) {
    const double place = (centre[d] - low_[d]) / cell_size_;
    if (!(place >= 0.0 && place < static_cast<double>(n_cells_[d]))) return {};
    cell[d] = static_cast<long>(place);
  }
  const std::size_t c = cell_index(cell[0], cell[1], cell[2]);
  return std::span(entries_).subspan(first_[c], first_[c + 1] - first_[c]);
}

// Where there are too many, the nearest are kept: the list is good for a shorter way.
void MeshSurface::search(const Vector3& centre, std::span<const std::uint32_t> cell, Nearby& nearby) const {
  std::array<double, Nearby::kMost> listed;  // squared distances
  double complete2 = reach_ * reach_;
  nearby.n = 0;
  for (const std::uint32_t t : cell) {
    double distance2 = least_distance2(t, centre);
    if (distance2 >= complete2) continue;
    std::size_t place = nearby.n;
    if (nearby.n == Nearby::kMost) {
      place = static_cast<std::size_t>(std::max_element(listed.begin(), listed.end()) - listed.begin());
      complete2 = std::max(distance2, listed[place]);
      if (distance2 >= listed[place]) continue;
    } else {
      ++nearby.n;
    }
    listed[place] = distance2;
    nearby.triangle[place] = t;
  }
  nearby.place = centre;
  nearby.complete = std::sqrt(complete2);
}

double MeshSurface::touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) {
  found.clear();
  if (radius > largest_radius_) {
    largest_radius_ = 1.02 * radius;
    build_cells(kReach * radius);
  }
  const Vector3 moved = centre - nearby.place;
  const double room = nearby.complete - radius;
  std::span<const std::uint32_t> candidates(nearby.triangle.data(), nearby.n);
  double clear = reach_;
  if (room > 0.0 && dot(moved, moved) < room * room) {
    clear = nearby.complete - norm(moved);
  } else {
    const auto cell = cell_at(centre);
    search(centre, cell, nearby);
    candidates = nearby.complete > radius ? std::span<const std::uint32_t>(nearby.triangle.data(), nearby.n) : cell;
    if (nearby.complete > radius) clear = nearby.complete;
  }

  near_.clear();
  double clear2 = clear * clear;
  for (const std::uint32_t t : candidates) {
    const Plane& plane = planes_[t];
    const double height = dot(centre, plane.normal) - plane.offset;
    if (std::abs(height) >= radius) {
      clear2 = std::min(clear2, height * height);
      continue;
    }
    const Face& face = faces_[t];
    const double of_b = dot(centre, face.to_b) - face.b, of_c = dot(centre, face.to_c) - face.c;
    const double of_a = 1.0 - of_b - of_c;
    if (of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0) {
      near_.push_back({touch_from(centre, centre - height * plane.normal, std::abs(height), plane.normal), t, true});
      continue;
    }
    // The farthest side that the centre is beyond of keeps at least this distance.
    const double beyond = std::max({-of_a * face.heights[0], -of_b * face.heights[1], -of_c * face.heights[2]});
    const double least2 = height * height + beyond * beyond;
    if (least2 >= radius * radius) {
      clear2 = std::min(clear2, least2);
      continue;
    }
    const Vector3 point = nearest_point(triangles_[t], centre);
    const Vector3 away = centre - point;
    const double distance2 = dot(away, away);
    clear2 = std::min(clear2, distance2);
    if (distance2 < radius * radius)
      near_.push_back({touch_from(centre, point, std::sqrt(distance2), plane.normal), t, false});
  }
  if (near_.empty()) return std::sqrt(clear2);

  std::sort(near_.begin(), near_.end(),
            [](const Candidate& a, const Candidate& b) { return a.touch.distance < b.touch.distance; });
  found.push_back(near_[0].touch);
  for (std::size_t n = 1; n < near_.size(); ++n) {
    const Candidate& candidate = near_[n];
    const bool merged = std::any_of(found.begin(), found.end(), [&](const SurfaceTouch& nearer) {
      return dot(nearer.normal, candidate.touch.normal) > same_direction_;
    });
    if (!merged && !comes_nearer_elsewhere(candidate) && !hidden(centre, candidate)) found.push_back(candidate.touch);
  }
  return near_[0].touch.distance;
}

// On a rim that also belongs to a triangle with a nearer point: no local minimum of the distance.
bool MeshSurface::comes_nearer_elsewhere(const Candidate& candidate) const {
  if (candidate.inside) return false;
  for (const Candidate& other : near_) {
    if (other.touch.distance > candidate.touch.distance * (1.0 - 1e-9)) return false;  // sorted: no nearer one follows
    const Vector3& point = candidate.touch.point;
    if (norm(point - nearest_point(triangles_[other.triangle], point)) <= same_point_) return true;
  }
  return false;
}

// Another triangle stands between the centre and the nearest point.
bool MeshSurface::hidden(const Vector3& centre, const Candidate& candidate) const {
  for (const Candidate& other : near_) {
    if (other.touch.distance >= candidate.touch.distance) return false;
    const Plane& plane = planes_[other.triangle];
    const double above = dot(centre, plane.normal) - plane.offset;
    const double below = dot(candidate.touch.point, plane.normal) - plane.offset;
    if (above * below >= 0.0 || std::abs(below) <= same_point_) continue;
    const Vector3 crossing = centre + (above / (above - below)) * (candidate.touch.point - centre);
    if (norm(crossing - nearest_point(triangles_[other.triangle], crossing)) <= same_point_) return true;
  }
  return false;
}

}  // namespace granary::dem
