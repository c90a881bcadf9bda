#include "dem_templates/plugin/wall/mesh_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace granary::dem {
namespace {

constexpr double kReach = 1.5;  // of the largest radius: who looked in vain need not look again for a while

constexpr double kNearer = 1e-6;  // of the radius: a neighbour that comes nearer by this does so beyond rounding

Vector3 normal_of(const Triangle& triangle) {
  const Vector3 area = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
  return (1.0 / norm(area)) * area;
}

std::array<float, 3> rounded(const Vector3& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

Vector3 unit(const Vector3& v) { return (1.0 / norm(v)) * v; }

}  // namespace

MeshSurface::MeshSurface(std::vector<Triangle> triangles, double smooth)
    : triangles_(std::move(triangles)), same_direction_(std::cos(smooth)) {
  Vector3 low = triangles_[0][0], high = low;
  for (const Triangle& triangle : triangles_) {
    const Vector3 normal = normal_of(triangle);
    Planes planes;
    const auto set = [&](std::size_t k, const Vector3& n, double offset) {
      planes.x[k] = n[0], planes.y[k] = n[1], planes.z[k] = n[2], planes.offset[k] = offset;
    };
    set(0, normal, dot(normal, triangle[0]));
    std::array<Side, 3> sides;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 &start = triangle[k], &end = triangle[(k + 1) % 3], along = unit(end - start);
      const Vector3 outwards = unit(cross(along, normal));
      set(k + 1, outwards, dot(outwards, start));
      sides[k] = {.from = dot(along, start), .to = dot(along, end)};
    }
    planes_.push_back(planes);
    Rounded rounded;
    for (std::size_t k = 0; k < 4; ++k) {
      rounded.x[k] = static_cast<float>(planes.x[k]), rounded.y[k] = static_cast<float>(planes.y[k]);
      rounded.z[k] = static_cast<float>(planes.z[k]), rounded.offset[k] = static_cast<float>(planes.offset[k]);
    }
    rounded_.push_back(rounded);
    sides_.push_back(sides);
    for (const Vector3& corner : triangle) {
      for (std::size_t d = 0; d < 3; ++d) {
        low[d] = std::min(low[d], corner[d]);
        high[d] = std::max(high[d], corner[d]);
      }
    }
  }
  same_point_ = 1e-6 * norm(high - low);
  rounding_ = 8.0 * std::numeric_limits<float>::epsilon() * (norm(low) + norm(high));
  join_sides();
}

// By the very same corners, which is how STL files have them. Where more than two triangles meet, any other will do.
void MeshSurface::join_sides() {
  struct Shared {
    Vector3 low, high;
    std::uint32_t triangle, side;
  };
  std::vector<Shared> all;
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles_[t][k], triangles_[t][(k + 1) % 3]);
      all.push_back({low, high, t, k});
    }
  std::sort(all.begin(), all.end(), [](const Shared& a, const Shared& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  for (std::size_t n = 1; n < all.size(); ++n) {
    const Shared &a = all[n - 1], &b = all[n];
    if (a.low != b.low || a.high != b.high) continue;
    const auto join = [this](const Shared& to, const Shared& from) {
      Side& side = sides_[to.triangle][to.side];
      const Vector3 into = -1.0 * planes_[from.triangle].normal(from.side + 1);
      side.on = dot(into, planes_[to.triangle].normal(to.side + 1));
      side.rise = dot(into, planes_[to.triangle].normal(0));
    };
    join(a, b);
    join(b, a);
  }
}

inline float MeshSurface::rough_distance2(std::uint32_t t, const std::array<float, 3>& p) const {
  const Rounded& planes = rounded_[t];
  const Four over = planes.x * p[0] + planes.y * p[1] + planes.z * p[2] - planes.offset;
  const float outside = std::max(0.0f, std::max(over[1], std::max(over[2], over[3])));
  return over[0] * over[0] + outside * outside;
}

inline MeshSurface::Heights MeshSurface::heights(std::uint32_t t, const Vector3& p) const {
  const Planes& planes = planes_[t];
  Heights over;
  for (int k = 0; k < 4; ++k)
    over.over[k] = planes.x[k] * p[0] + planes.y[k] * p[1] + planes.z[k] * p[2] - planes.offset[k];
  return over;
}

double MeshSurface::height(std::uint32_t t, const Vector3& p) const {
  const Planes& planes = planes_[t];
  return planes.x[0] * p[0] + planes.y[0] * p[1] + planes.z[0] * p[2] - planes.offset[0];
}

double MeshSurface::farthest_from(const Vector3& origin, const Vector3& unit_axis) const {
  double farthest = 0.0;
  for (const Triangle& triangle : triangles_)
    for (const Vector3& corner : triangle) farthest = std::max(farthest, norm(cross(unit_axis, corner - origin)));
  return farthest;
}

bool MeshSurface::contains(std::uint32_t t, const Vector3& p) const {
  const Heights over = heights(t, p);
  if (std::abs(over.face()) > same_point_ || over.beyond() > same_point_) return false;
  return over.beyond() <= 0.0 || norm(p - nearest_point(triangles_[t], p)) <= same_point_;
}

bool MeshSurface::between(const Vector3& from, const Vector3& to) const {
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const double before = height(t, from), after = height(t, to);
    if (before * after < 0.0 && heights(t, from + (before / (before - after)) * (to - from)).beyond() <= 0.0)
      return true;
  }
  return false;
}

// Where more are near than can be listed, the list is good for a shorter way.
void MeshSurface::search(const Vector3& centre, const TriangleCells::Near& near, Nearby& nearby) const {
  const auto rough = rounded(centre);
  double complete = near.clear;
  nearby.n = 0;
  for (const auto& [t, from_middle] : near.entries) {
    const double least = static_cast<double>(from_middle) - near.off_middle;
    if (least >= complete) break;  // so are all that follow
    const double distance = std::max(0.0, static_cast<double>(std::sqrt(rough_distance2(t, rough))) - rounding_);
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
  nearby.place = rough;
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
  const auto rough = rounded(centre);
  const float touching2 = static_cast<float>((radius + rounding_) * (radius + rounding_));
  float rough_clear2 = std::numeric_limits<float>::max();
  for (const auto& [t, distance] : parts) {
    const double least = static_cast<double>(distance) - moved;
    if (least >= radius) {  // so are all that follow
      clear2 = std::min(clear2, least * least);
      break;
    }
    const float rough2 = rough_distance2(t, rough);
    if (rough2 >= touching2) {
      rough_clear2 = std::min(rough_clear2, rough2);
      continue;
    }
    const Heights over = heights(t, centre);
    const double h = over.face(), outside = std::max(0.0, over.beyond()), least2 = h * h + outside * outside;
    clear2 = std::min(clear2, least2);
    if (least2 >= radius * radius) continue;
    if (outside <= 0.0) {
      near_.push_back({std::abs(h), t, Candidate::Kind::inside, {}});
      continue;
    }
    const Candidate candidate = on_rim(t, centre, radius, over);
    if (candidate.distance < radius) near_.push_back(candidate);
  }
  return std::min(std::sqrt(clear2), static_cast<double>(std::sqrt(rough_clear2)) - rounding_);
}

// Beyond a side, between its ends, that side is nearest; else a corner is.
MeshSurface::Candidate MeshSurface::on_rim(std::uint32_t t, const Vector3& centre, double radius,
                                           const Heights& over) const {
  const Planes& planes = planes_[t];
  const Vector3 normal = planes.normal(0);
  for (std::size_t k = 0; k < 3; ++k) {
    const double out = over.over[k + 1];
    if (out <= 0.0) continue;
    const Side& side = sides_[t][k];
    const Vector3 outwards = planes.normal(k + 1);
    const double along = dot(centre, cross(normal, outwards));
    if (along < side.from || along > side.to) continue;
    const double distance = std::sqrt(over.face() * over.face() + out * out);
    if (side.on * out + side.rise * over.face() > kNearer * radius) return {distance, t, Candidate::Kind::seam, {}};
    return {distance, t, Candidate::Kind::rim, centre - over.face() * normal - out * outwards};
  }
  const Vector3 point = nearest_point(triangles_[t], centre);
  return {norm(centre - point), t, Candidate::Kind::rim, point};
}

// Its normal points to the centre; where the centre lies in the surface, it is the surface's own.
SurfaceTouch MeshSurface::touch(const Vector3& centre, const Candidate& candidate) const {
  const auto& [distance, t, kind, point] = candidate;
  const Vector3 normal = planes_[t].normal(0);
  if (kind == Candidate::Kind::inside) {
    const double h = height(t, centre);
    return {distance, centre - h * normal, h < 0.0 ? -1.0 * normal : normal, t};
  }
  return {distance, point, distance > 1e-14 ? (1.0 / distance) * (centre - point) : normal, t};
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
    return a.distance == b.distance ? a.triangle < b.triangle : a.distance < b.distance;
  });
  for (const Candidate& candidate : near_) {
    if (candidate.kind == Candidate::Kind::seam) continue;
    const SurfaceTouch here = touch(centre, candidate);
    const bool merged = std::any_of(found.begin(), found.end(), [&](const SurfaceTouch& nearer) {
      return dot(nearer.normal, here.normal) > same_direction_;
    });
    if (merged || (!found.empty() && (comes_nearer_elsewhere(candidate) || hidden(centre, here)))) continue;
    found.push_back(here);
  }
  return near_[0].distance;
}

// On a rim that also belongs to a triangle with a nearer point: no local minimum of the distance.
bool MeshSurface::comes_nearer_elsewhere(const Candidate& candidate) const {
  if (candidate.kind == Candidate::Kind::inside) return false;
  for (const Candidate& other : near_) {
    if (other.distance > candidate.distance * (1.0 - 1e-9)) return false;  // sorted: no nearer one follows
    if (contains(other.triangle, candidate.point)) return true;
  }
  return false;
}

// Another triangle stands between the centre and the nearest point.
bool MeshSurface::hidden(const Vector3& centre, const SurfaceTouch& behind) const {
  for (const Candidate& other : near_) {
    if (other.distance >= behind.distance) return false;
    const double above = height(other.triangle, centre), below = height(other.triangle, behind.point);
    if (above * below >= 0.0 || std::abs(below) <= same_point_) continue;
    if (contains(other.triangle, centre + (above / (above - below)) * (behind.point - centre))) return true;
  }
  return false;
}

}  // namespace granary::dem
