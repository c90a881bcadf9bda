#include "dem_templates/plugin/wall/mesh_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace granary::dem {
namespace {

constexpr double kReach = 1.5;  // of the largest radius: who looked in vain need not look again for a while

// Towards the centre; where the centre lies in the surface, the surface's own normal.
SurfaceTouch touch_from(const Vector3& centre, const Vector3& point, double distance, const Vector3& own_normal,
                        std::uint32_t triangle) {
  const bool apart = distance > 1e-14;
  return {distance, point, apart ? (1.0 / distance) * (centre - point) : own_normal, triangle};
}

}  // namespace

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
  rounding_ = 8.0 * std::numeric_limits<float>::epsilon() * (norm(low) + norm(high));
}

double MeshSurface::farthest_from(const Vector3& origin, const Vector3& unit_axis) const {
  double farthest = 0.0;
  for (const Triangle& triangle : triangles_)
    for (const Vector3& corner : triangle) farthest = std::max(farthest, norm(cross(unit_axis, corner - origin)));
  return farthest;
}

double MeshSurface::beyond(std::uint32_t t, const Vector3& p) const {
  const Face& face = faces_[t];
  const double of_b = dot(p, face.to_b) - face.b, of_c = dot(p, face.to_c) - face.c, of_a = 1.0 - of_b - of_c;
  return std::max({-of_a * face.heights[0], -of_b * face.heights[1], -of_c * face.heights[2]});
}

bool MeshSurface::contains(std::uint32_t t, const Vector3& p) const {
  return std::abs(height(t, p)) <= same_point_ && beyond(t, p) <= same_point_ &&
         norm(p - nearest_point(triangles_[t], p)) <= same_point_;
}

bool MeshSurface::between(const Vector3& from, const Vector3& to) const {
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const double before = height(t, from), after = height(t, to);
    if (before * after < 0.0 && beyond(t, from + (before / (before - after)) * (to - from)) <= 0.0) return true;
  }
  return false;
}

// Where more are near than can be listed, the list is good for a shorter way.
void MeshSurface::search(const Vector3& centre, const TriangleCells::Near& near, Nearby& nearby) const {
  double complete = near.clear;
  nearby.n = 0;
  for (const auto& [t, from_middle] : near.entries) {
    const double least = static_cast<double>(from_middle) - near.off_middle;
    if (least >= complete) break;  // so are all that follow
    const double h = height(t, centre), outside = std::max(0.0, beyond(t, centre));
    const double distance = std::sqrt(h * h + outside * outside);
    if (distance >= complete) continue;
    if (nearby.n == Nearby::kMost)
      complete = std::max(distance, static_cast<double>(nearby.part[nearby.n - 1].distance));
    if (distance >= complete) continue;
    if (nearby.n < Nearby::kMost) ++nearby.n;
    std::uint32_t place = nearby.n - 1;
    for (; place > 0 && nearby.part[place - 1].distance > static_cast<float>(distance); --place)
      nearby.part[place] = nearby.part[place - 1];
    nearby.part[place] = {t, static_cast<float>(distance)};
  }
  for (std::size_t d = 0; d < 3; ++d) nearby.place[d] = static_cast<float>(centre[d]);
  nearby.complete = static_cast<float>(complete);
}

double MeshSurface::find_touching(const Vector3& centre, double radius, Nearby& nearby) {
  near_.clear();
  std::span<const NearPart> parts(nearby.part.data(), nearby.n);
  double complete = nearby.complete;
  double moved = norm(centre - Vector3{nearby.place[0], nearby.place[1], nearby.place[2]}) + rounding_;
  if (complete < radius + moved) {
    const TriangleCells::Near near = cells_.near(centre);
    search(centre, near, nearby);
    complete = nearby.complete;
    moved = rounding_;
    parts = {nearby.part.data(), nearby.n};
    if (complete < radius + moved) {  // so many that they could not be listed
      parts = near.entries;
      complete = near.clear + near.off_middle;
      moved = near.off_middle;
    }
  }
  double clear2 = std::pow(std::max(0.0, complete - moved), 2);
  for (const auto& [t, distance] : parts) {
    const double least = static_cast<double>(distance) - moved;
    if (least >= radius) {  // so are all that follow
      clear2 = std::min(clear2, least * least);
      break;
    }
    const double h = height(t, centre);
    if (std::abs(h) >= radius) {
      clear2 = std::min(clear2, h * h);
      continue;
    }
    const double outside = beyond(t, centre);
    if (outside <= 0.0) {
      near_.push_back({touch_from(centre, centre - h * planes_[t].normal, std::abs(h), planes_[t].normal, t), true});
      continue;
    }
    const double least2 = h * h + outside * outside;
    if (least2 >= radius * radius) {
      clear2 = std::min(clear2, least2);
      continue;
    }
    const Vector3 point = nearest_point(triangles_[t], centre);
    const Vector3 away = centre - point;
    const double distance2 = dot(away, away);
    clear2 = std::min(clear2, distance2);
    if (distance2 < radius * radius)
      near_.push_back({touch_from(centre, point, std::sqrt(distance2), planes_[t].normal, t), false});
  }
  return std::sqrt(clear2);
}

double MeshSurface::touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) {
  found.clear();
  if (radius > largest_radius_) {
    largest_radius_ = 1.02 * radius;
    cells_ = TriangleCells(triangles_, kReach * largest_radius_);
    nearby.complete = 0.0f;
  }
  const double clear = find_touching(centre, radius, nearby);
  if (near_.empty()) return clear;

  // Equal distances by number: the order in which they were found must not show.
  std::sort(near_.begin(), near_.end(), [](const Candidate& a, const Candidate& b) {
    const bool equal = a.touch.distance == b.touch.distance;
    return equal ? a.touch.part < b.touch.part : a.touch.distance < b.touch.distance;
  });
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
    if (contains(other.touch.part, candidate.touch.point)) return true;
  }
  return false;
}

// Another triangle stands between the centre and the nearest point.
bool MeshSurface::hidden(const Vector3& centre, const Candidate& candidate) const {
  for (const Candidate& other : near_) {
    if (other.touch.distance >= candidate.touch.distance) return false;
    const double above = height(other.touch.part, centre), below = height(other.touch.part, candidate.touch.point);
    if (above * below >= 0.0 || std::abs(below) <= same_point_) continue;
    if (contains(other.touch.part, centre + (above / (above - below)) * (candidate.touch.point - centre))) return true;
  }
  return false;
}

}  // namespace granary::dem
