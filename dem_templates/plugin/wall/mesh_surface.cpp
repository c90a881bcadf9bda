#include "dem_templates/plugin/wall/mesh_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace granary::dem {
namespace {

constexpr double kReach = 1.5;  // of the largest radius: who looked in vain need not look again for a while

constexpr double kFlat = 1e-9;    // of the mesh: corners of a face are off its plane by less
constexpr double kNearer = 1e-6;  // of the radius: a neighbour that comes nearer by this does so beyond rounding

std::array<float, 3> rounded(const Vector3& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

Vector3 unit(const Vector3& v) { return (1.0 / norm(v)) * v; }

std::size_t n_sides(const Face& face) { return face.is_triangle() ? 3 : 4; }

}  // namespace

MeshSurface::MeshSurface(std::vector<Triangle> triangles, double smooth)
    : triangles_(std::move(triangles)), same_direction_(std::cos(smooth)) {
  Vector3 low = triangles_[0][0], high = low;
  for (const Triangle& triangle : triangles_) {
    for (const Vector3& corner : triangle) {
      for (std::size_t d = 0; d < 3; ++d) {
        low[d] = std::min(low[d], corner[d]);
        high[d] = std::max(high[d], corner[d]);
      }
    }
  }
  const double size = norm(high - low);
  same_point_ = 1e-6 * size;
  rounding_ = 8.0 * std::numeric_limits<float>::epsilon() * (norm(low) + norm(high));
  faces_ = faces_of(triangles_, kFlat * size);
  for (const Face& face : faces_) {
    const auto& corner = face.corner;
    const Vector3 normal = unit(cross(corner[1] - corner[0], corner[2] - corner[0]));
    Planes planes;
    std::array<Side, 4> sides;
    planes.normal = normal, planes.height = dot(normal, corner[0]);
    for (std::size_t k = 0; k < n_sides(face); ++k) {
      const Vector3 &start = corner[k], &end = corner[(k + 1) % n_sides(face)], along = unit(end - start);
      const Vector3 out = unit(cross(along, normal));
      planes.x[k] = out[0], planes.y[k] = out[1], planes.z[k] = out[2], planes.offset[k] = dot(out, start);
      sides[k] = {.from = dot(along, start), .to = dot(along, end)};
    }
    if (face.is_triangle()) {
      for (double* column : {planes.x, planes.y, planes.z, planes.offset}) column[3] = column[2];
      sides[3] = sides[2];
    }
    Rounded rounded;
    for (int k = 0; k < 4; ++k) {
      rounded.x[k] = static_cast<float>(planes.x[k]), rounded.y[k] = static_cast<float>(planes.y[k]);
      rounded.z[k] = static_cast<float>(planes.z[k]), rounded.offset[k] = static_cast<float>(planes.offset[k]);
    }
    for (std::size_t d = 0; d < 3; ++d) rounded.normal[d] = static_cast<float>(normal[d]);
    rounded.height = static_cast<float>(planes.height);
    planes_.push_back(planes);
    rounded_.push_back(rounded);
    sides_.push_back(sides);
  }
  join_sides();
}

// Where more than two faces meet, any other will do.
void MeshSurface::join_sides() {
  std::vector<SharedSide> all;
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    const std::size_t n = n_sides(faces_[f]);
    for (std::uint32_t k = 0; k < n; ++k) {
      const auto [low, high] = std::minmax(faces_[f].corner[k], faces_[f].corner[(k + 1) % n]);
      all.push_back({low, high, f, k});
    }
  }
  sort_by_ends(all);
  for (std::size_t n = 1; n < all.size(); ++n) {
    if (!same_ends(all[n - 1], all[n])) continue;
    const auto join = [this](const SharedSide& to, const SharedSide& from) {
      Side& side = sides_[to.owner][to.side];
      const Vector3 into = -1.0 * planes_[from.owner].outwards(from.side);
      side.on = dot(into, planes_[to.owner].outwards(to.side));
      side.rise = dot(into, planes_[to.owner].normal);
      if (faces_[to.owner].is_triangle()) sides_[to.owner][3] = sides_[to.owner][2];
    };
    join(all[n - 1], all[n]);
    join(all[n], all[n - 1]);
  }
}

inline float MeshSurface::rough_distance2(std::uint32_t f, const std::array<float, 3>& p) const {
  const Rounded& planes = rounded_[f];
  const Four over = planes.x * p[0] + planes.y * p[1] + planes.z * p[2] - planes.offset;
  const float outside = std::max(0.0f, std::max(std::max(over[0], over[1]), std::max(over[2], over[3])));
  const float height = planes.normal[0] * p[0] + planes.normal[1] * p[1] + planes.normal[2] * p[2] - planes.height;
  return height * height + outside * outside;
}

inline MeshSurface::Heights MeshSurface::heights(std::uint32_t f, const Vector3& p) const {
  const Planes& planes = planes_[f];
  Heights over;
  for (int k = 0; k < 4; ++k)
    over.over[k] = planes.x[k] * p[0] + planes.y[k] * p[1] + planes.z[k] * p[2] - planes.offset[k];
  over.face = height(f, p);
  return over;
}

// The triangle that the point is farthest inside of, or least outside.
std::size_t MeshSurface::part_at(const SurfaceTouch& touch) const {
  const std::vector<std::uint32_t>& parts = faces_[touch.face].triangles;
  const Vector3& normal = planes_[touch.face].normal;
  std::size_t best = parts[0];
  double deepest = std::numeric_limits<double>::lowest();
  for (std::size_t p = 0; p < parts.size() && deepest < 0.0; ++p) {
    const Triangle& corner = triangles_[parts[p]];
    double inside = std::numeric_limits<double>::max();
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 along = corner[(k + 1) % 3] - corner[k];
      inside = std::min(inside, dot(cross(normal, along), touch.point - corner[k]) / norm(along));
    }
    if (inside <= deepest) continue;
    deepest = inside;
    best = parts[p];
  }
  return best;
}

double MeshSurface::farthest_from(const Vector3& origin, const Vector3& unit_axis) const {
  double farthest = 0.0;
  for (const Triangle& triangle : triangles_)
    for (const Vector3& corner : triangle) farthest = std::max(farthest, norm(cross(unit_axis, corner - origin)));
  return farthest;
}

bool MeshSurface::contains(std::uint32_t f, const Vector3& p) const {
  const Heights over = heights(f, p);
  if (std::abs(over.face) > same_point_ || over.beyond() > same_point_) return false;
  return over.beyond() <= 0.0 || norm(p - nearest_point(faces_[f], p)) <= same_point_;
}

bool MeshSurface::between(const Vector3& from, const Vector3& to) const {
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    const double before = height(f, from), after = height(f, to);
    if (before * after < 0.0 && heights(f, from + (before / (before - after)) * (to - from)).beyond() <= 0.0)
      return true;
  }
  return false;
}

// Where more are near than can be listed, the list is good for a shorter way.
void MeshSurface::search(const Vector3& centre, const FaceCells::Near& near, Nearby& nearby) const {
  const auto rough = rounded(centre);
  double complete = near.clear;
  nearby.n = 0;
  for (const auto& [f, from_middle] : near.entries) {
    const double least = static_cast<double>(from_middle) - near.off_middle;
    if (least >= complete) break;  // so are all that follow
    const double distance = std::max(0.0, static_cast<double>(std::sqrt(rough_distance2(f, rough))) - rounding_);
    if (distance >= complete) continue;
    if (nearby.n == Nearby::kMost)
      complete = std::max(distance, static_cast<double>(nearby.part[nearby.n - 1].distance));
    if (distance >= complete) continue;
    if (nearby.n < Nearby::kMost) ++nearby.n;
    std::uint32_t place = nearby.n - 1;
    for (; place > 0 && nearby.part[place - 1].distance > static_cast<float>(distance); --place)
      nearby.part[place] = nearby.part[place - 1];
    nearby.part[place] = {f, static_cast<float>(distance)};
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
    const FaceCells::Near near = cells_.near(centre);
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
  for (const auto& [f, distance] : parts) {
    const double least = static_cast<double>(distance) - moved;
    if (least >= radius) {  // so are all that follow
      clear2 = std::min(clear2, least * least);
      break;
    }
    const float rough2 = rough_distance2(f, rough);
    if (rough2 >= touching2) {
      rough_clear2 = std::min(rough_clear2, rough2);
      continue;
    }
    const Heights over = heights(f, centre);
    const double h = over.face, outside = std::max(0.0, over.beyond()), least2 = h * h + outside * outside;
    clear2 = std::min(clear2, least2);
    if (least2 >= radius * radius) continue;
    if (outside <= 0.0) {
      Candidate& inside = near_.emplace_back();  // in place: a copy waits for what was just written
      inside.distance = std::abs(h);
      inside.face = f;
      inside.kind = Candidate::Kind::inside;
      continue;
    }
    const Candidate candidate = on_rim(f, centre, radius, over);
    if (candidate.distance < radius) near_.push_back(candidate);
  }
  return std::min(std::sqrt(clear2), static_cast<double>(std::sqrt(rough_clear2)) - rounding_);
}

// Beyond a side, between its ends, that side is nearest; else a corner is.
MeshSurface::Candidate MeshSurface::on_rim(std::uint32_t f, const Vector3& centre, double radius,
                                           const Heights& over) const {
  const Planes& planes = planes_[f];
  for (std::size_t k = 0; k < 4; ++k) {
    const double out = over.over[k];
    if (out <= 0.0) continue;
    const Side& side = sides_[f][k];
    const Vector3 outwards = planes.outwards(k);
    const double along = dot(centre, cross(planes.normal, outwards));
    if (along < side.from || along > side.to) continue;
    const double distance = std::sqrt(over.face * over.face + out * out);
    if (side.on * out + side.rise * over.face > kNearer * radius) return {distance, f, Candidate::Kind::seam, {}};
    return {distance, f, Candidate::Kind::rim, centre - over.face * planes.normal - out * outwards};
  }
  Vector3 nearest = faces_[f].corner[0];
  for (const Vector3& corner : faces_[f].corner)
    if (dot(centre - corner, centre - corner) < dot(centre - nearest, centre - nearest)) nearest = corner;
  return {norm(centre - nearest), f, Candidate::Kind::rim, nearest};
}

// Its normal points to the centre; where the centre lies in the surface, it is the surface's own.
SurfaceTouch MeshSurface::touch(const Vector3& centre, const Candidate& candidate) const {
  const auto& [distance, f, kind, point] = candidate;
  const Vector3 normal = planes_[f].normal;
  if (kind == Candidate::Kind::inside) {
    const double h = height(f, centre);
    return {distance, centre - h * normal, h < 0.0 ? -1.0 * normal : normal, f};
  }
  return {distance, point, distance > 1e-14 ? (1.0 / distance) * (centre - point) : normal, f};
}

double MeshSurface::touches(const Vector3& centre, double radius, Nearby& nearby, std::vector<SurfaceTouch>& found) {
  found.clear();
  if (radius > largest_radius_) {
    largest_radius_ = 1.02 * radius;
    cells_ = FaceCells(faces_, kReach * largest_radius_);
    nearby.complete = 0.0f;
  }
  const double clear = find_touching(centre, radius, nearby);
  if (near_.empty()) return clear;

  // Equal distances by number: the order in which they were found must not show.
  std::sort(near_.begin(), near_.end(), [](const Candidate& a, const Candidate& b) {
    return a.distance == b.distance ? a.face < b.face : a.distance < b.distance;
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

// On a rim that also belongs to a face with a nearer point: no local minimum of the distance.
bool MeshSurface::comes_nearer_elsewhere(const Candidate& candidate) const {
  if (candidate.kind == Candidate::Kind::inside) return false;
  for (const Candidate& other : near_) {
    if (other.distance > candidate.distance * (1.0 - 1e-9)) return false;  // sorted: no nearer one follows
    if (contains(other.face, candidate.point)) return true;
  }
  return false;
}

// Another face stands between the centre and the nearest point.
bool MeshSurface::hidden(const Vector3& centre, const SurfaceTouch& behind) const {
  for (const Candidate& other : near_) {
    if (other.distance >= behind.distance) return false;
    const double above = height(other.face, centre), below = height(other.face, behind.point);
    if (above * below >= 0.0 || std::abs(below) <= same_point_) continue;
    if (contains(other.face, centre + (above / (above - below)) * (behind.point - centre))) return true;
  }
  return false;
}

}  // namespace granary::dem
