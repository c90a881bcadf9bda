#include "dem_templates/plugin/wall/mesh_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "common/every_width.hpp"

namespace granary::dem {
namespace {

constexpr double kReach = 1.5;  // of the largest radius: who looked in vain need not look again for a while

constexpr double kRoundUp = 1.0 + 1e-6;
constexpr double kFlat = 1e-9;    // of the mesh: corners of a face are off its plane by less
constexpr double kNearer = 1e-6;  // of the radius: a neighbour that comes nearer by this does so beyond rounding

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
      for (Four* column : {&planes.x, &planes.y, &planes.z, &planes.offset}) (*column)[3] = (*column)[2];
      sides[3] = sides[2];
    }
    planes_.push_back(planes);
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

inline MeshSurface::Heights MeshSurface::heights(const Planes& planes, const Vector3& p) {
  return {planes.x * p[0] + planes.y * p[1] + planes.z * p[2] - planes.offset, dot(planes.normal, p) - planes.height};
}

// Without branches: no sphere waits for another.
GRANARY_EVERY_WIDTH void MeshSurface::measure(const Planes* planes, const Look* looks, const Pair* pairs, std::size_t n,
                                              Measured* measured) {
  for (std::size_t p = 0; p < n; ++p) {
    measured[p] = heights(planes[pairs[p].face], looks[pairs[p].look].centre).measured();
  }
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
  double complete = near.clear;
  std::size_t n = 0;
  for (const auto& [f, from_middle] : near.entries) {
    const double least = static_cast<double>(from_middle) - near.off_middle;
    if (least >= complete) break;  // so are all that follow
    const double distance = std::sqrt(heights(f, centre).measured().distance2);
    if (distance >= complete) continue;
    if (n == Nearby::kMost) complete = std::max(distance, static_cast<double>(nearby.distance(n - 1)));
    if (distance >= complete) continue;
    if (n < Nearby::kMost) ++n;
    const NearPart here{f, static_cast<float>(distance)};
    std::size_t place = n - 1;
    for (; place > 0 && nearby.distance(place - 1) > here.distance; --place) nearby.set(place, nearby.part(place - 1));
    nearby.set(place, here);
  }
  nearby.end_after(n);
  for (std::size_t d = 0; d < 3; ++d) nearby.place[d] = static_cast<float>(centre[d]);
  nearby.complete = static_cast<float>(complete);
}

inline double MeshSurface::moved(const Look& look) const {
  const auto& [x, y, z] = look.nearby->place;
  return norm(look.centre - Vector3{x, y, z}) + rounding_;
}

// A cell and what it lists lie anywhere in memory: all are asked for before the first is used.
void MeshSurface::search_again(std::span<Look> looks) {
  lost_.clear();
  if (moved_.size() < looks.size()) moved_.resize(looks.size());
  for (std::uint32_t l = 0; l < looks.size(); ++l) {
    Look& look = looks[l];
    moved_[l] = moved(look);
    if (look.nearby->complete >= look.radius + moved_[l]) continue;
    cells_.fetch(look.centre);
    lost_.push_back(l);
  }
  searched_.resize(lost_.size());
  for (std::size_t k = 0; k < lost_.size(); ++k) {
    searched_[k] = cells_.near(looks[lost_[k]].centre);
    __builtin_prefetch(searched_[k].entries.data());
  }
  for (std::size_t k = 0; k < lost_.size(); ++k) {
    const Look& look = looks[lost_[k]];
    search(look.centre, searched_[k], *look.nearby);
    moved_[lost_[k]] = moved(look);
  }
}

inline void MeshSurface::find_pairs(Look& look, std::uint32_t number) {
  const Nearby& nearby = *look.nearby;
  const double off = moved_[number];
  if (nearby.complete < look.radius + off) {  // so many that they could not be listed
    const FaceCells::Near near = cells_.near(look.centre);
    if (pairs_.size() < n_pairs_ + near.entries.size()) grow(n_pairs_ + near.entries.size());
    for (const NearPart& part : near.entries) pairs_[n_pairs_++] = {number, part.number};
    look.clear = near.clear;
    return;
  }
  if (pairs_.size() < n_pairs_ + Nearby::kMost) grow(n_pairs_ + Nearby::kMost);
  const auto reach = static_cast<float>((look.radius + off) * kRoundUp);
  std::size_t n = 0;
  for (const Nearby::Row& row : nearby.row) {
    std::uint32_t nearer = 0;
    for (std::size_t k = 0; k < Nearby::kRow; ++k) {
      pairs_[n_pairs_ + n + k] = {number, row.number[k]};
      nearer += row.distance[k] < reach ? 1 : 0;
    }
    n += nearer;
    if (nearer < Nearby::kRow) break;
  }
  n_pairs_ += n;
  look.clear = std::max(0.0, static_cast<double>(std::min(nearby.complete, nearby.distance(n))) - off);
}

// Beyond a side, between its ends, that side is nearest; else a corner is.
void MeshSurface::find_on_rim(const Vector3& centre, double radius, Candidate& found) const {
  const Planes& planes = planes_[found.face];
  const Heights over = heights(planes, centre);
  found.kind = Candidate::Kind::rim;
  for (std::size_t k = 0; k < 4; ++k) {
    const double out = over.over[k];
    if (out <= 0.0) continue;
    const Side& side = sides_[found.face][k];
    const Vector3 outwards = planes.outwards(k);
    const double along = dot(centre, cross(planes.normal, outwards));
    if (along < side.from || along > side.to) continue;
    found.distance = std::sqrt(over.face * over.face + out * out);
    found.point = centre - over.face * planes.normal - out * outwards;
    if (side.on * out + side.rise * over.face > kNearer * radius) found.kind = Candidate::Kind::seam;
    return;
  }
  const auto& corners = faces_[found.face].corner;
  found.point = *std::min_element(corners.begin(), corners.end(), [&](const Vector3& a, const Vector3& b) {
    return dot(centre - a, centre - a) < dot(centre - b, centre - b);
  });
  found.distance = norm(centre - found.point);
}

// Its normal points to the centre; where the centre lies in the surface, it is the surface's own.
inline void MeshSurface::set_inside(const Vector3& centre, std::uint32_t f, double h, SurfaceTouch& touch) const {
  const Vector3& normal = planes_[f].normal;
  touch.distance = std::abs(h);
  touch.face = f;
  const double side = h < 0.0 ? -1.0 : 1.0;
  for (std::size_t d = 0; d < 3; ++d) {
    touch.point[d] = centre[d] - h * normal[d];
    touch.normal[d] = side * normal[d];
  }
}
inline void MeshSurface::set_touch(const Vector3& centre, const Candidate& candidate, SurfaceTouch& touch) const {
  const auto& [distance, f, kind, h, point] = candidate;
  if (kind == Candidate::Kind::inside) return set_inside(centre, f, h, touch);
  touch.distance = distance;
  touch.face = f;
  for (std::size_t d = 0; d < 3; ++d) {
    touch.point[d] = point[d];
    touch.normal[d] = distance > 1e-14 ? (centre[d] - point[d]) / distance : planes_[f].normal[d];
  }
}

void MeshSurface::grow(std::size_t n_pairs) {
  pairs_.resize(2 * n_pairs);
  measured_.resize(pairs_.size());
  reached_.resize(pairs_.size());
  candidates_.resize(pairs_.size());
}

void MeshSurface::look(std::span<Look> looks, std::vector<SurfaceTouch>& found) {
  for (const Look& look : looks) {
    if (look.radius <= largest_radius_) continue;
    largest_radius_ = 1.02 * look.radius;
    cells_ = FaceCells(faces_, kReach * largest_radius_);
  }
  search_again(looks);
  n_pairs_ = 0;
  for (std::uint32_t l = 0; l < looks.size(); ++l) find_pairs(looks[l], l);
  measure(planes_.data(), looks.data(), pairs_.data(), n_pairs_, measured_.data());
  found.clear();
  std::size_t pair = 0;
  for (std::uint32_t l = 0; l < looks.size(); ++l) {
    Look& look = looks[l];
    double clear2 = look.clear * look.clear;
    const double radius2 = look.radius * look.radius;
    n_reached_ = 0;
    for (; pair < n_pairs_ && pairs_[pair].look == l; ++pair) {
      const double distance2 = measured_[pair].distance2;
      clear2 = std::min(clear2, distance2);
      reached_[n_reached_] = static_cast<std::uint32_t>(pair);
      n_reached_ += distance2 < radius2 ? 1 : 0;
    }
    look.first = static_cast<std::uint32_t>(found.size());
    if (n_reached_ == 0 || !touches(look, found)) look.clear = std::sqrt(clear2);
    look.n = static_cast<std::uint32_t>(found.size()) - look.first;
  }
}

// One product of the normals says what else touch(), hidden() and a comparison of directions find out.
bool MeshSurface::touches_two_insides(Look& look, std::vector<SurfaceTouch>& found) const {
  const auto height_of = [&](std::size_t r) { return measured_[reached_[r]].height; };
  const auto face_of = [&](std::size_t r) { return pairs_[reached_[r]].face; };
  const double first = std::abs(height_of(0)), second = std::abs(height_of(1));
  const std::size_t a = is_before(first, face_of(0), second, face_of(1)) ? 0 : 1, b = 1 - a;
  const double near = height_of(a), far = height_of(b);
  const double alike = dot(planes_[face_of(a)].normal, planes_[face_of(b)].normal);
  const double below = near - far * alike;  // height of the point on the farther face over the nearer one
  if (near * below < 0.0 && std::abs(below) > same_point_ && first != second) return false;
  look.clear = std::abs(near);
  set_inside(look.centre, face_of(a), near, found.emplace_back());
  if ((near * far < 0.0 ? -alike : alike) <= same_direction_)
    set_inside(look.centre, face_of(b), far, found.emplace_back());
  return true;
}

// Most spheres lean on the inside of one flat, or of two.
bool MeshSurface::touches(Look& look, std::vector<SurfaceTouch>& found) {
  const auto inside = [&](std::size_t r) { return measured_[reached_[r]].beyond <= 0.0; };
  if (n_reached_ == 1 && inside(0)) {
    const double h = measured_[reached_[0]].height;
    look.clear = std::abs(h);
    set_inside(look.centre, pairs_[reached_[0]].face, h, found.emplace_back());
    return true;
  }
  if (n_reached_ == 2 && inside(0) && inside(1) && touches_two_insides(look, found)) return true;
  // Each in its place: a copy would wait for what was just written.
  near_.clear();
  for (std::size_t r = 0; r < n_reached_; ++r) {
    const auto& [height, beyond, distance2] = measured_[reached_[r]];
    Candidate& candidate = candidates_[near_.size()];
    candidate.face = pairs_[reached_[r]].face;
    candidate.height = height;
    if (beyond <= 0.0) {
      candidate.kind = Candidate::Kind::inside;
      candidate.distance = std::abs(height);
    } else {
      find_on_rim(look.centre, look.radius, candidate);
      if (candidate.distance >= look.radius) continue;
    }
    near_.push_back(&candidate);
    for (std::size_t k = near_.size() - 1; k > 0 && near_[k]->before(*near_[k - 1]); --k)
      std::swap(near_[k], near_[k - 1]);
  }
  if (near_.empty()) return false;
  look.clear = near_[0]->distance;
  for (const Candidate* candidate : near_) {
    if (candidate->kind == Candidate::Kind::seam) continue;
    SurfaceTouch& here = found.emplace_back();
    set_touch(look.centre, *candidate, here);
    const std::span<const SurfaceTouch> nearer = std::span(found).subspan(look.first, found.size() - 1 - look.first);
    const bool merged = std::any_of(nearer.begin(), nearer.end(), [&](const SurfaceTouch& other) {
      return dot(other.normal, here.normal) > same_direction_;
    });
    if (merged || (!nearer.empty() && (comes_nearer_elsewhere(*candidate) || hidden(look.centre, here))))
      found.pop_back();
  }
  return true;
}

// On a rim that also belongs to a face with a nearer point: no local minimum of the distance.
bool MeshSurface::comes_nearer_elsewhere(const Candidate& candidate) const {
  if (candidate.kind == Candidate::Kind::inside) return false;
  for (const Candidate* other : near_) {
    if (other->distance > candidate.distance * (1.0 - 1e-9)) return false;  // sorted: no nearer one follows
    if (contains(other->face, candidate.point)) return true;
  }
  return false;
}

// Another face stands between the centre and the nearest point.
bool MeshSurface::hidden(const Vector3& centre, const SurfaceTouch& behind) const {
  for (const Candidate* other : near_) {
    if (other->distance >= behind.distance) return false;
    const double above = other->height, below = height(other->face, behind.point);
    if (above * below >= 0.0 || std::abs(below) <= same_point_) continue;
    if (contains(other->face, centre + (above / (above - below)) * (behind.point - centre))) return true;
  }
  return false;
}

}  // namespace granary::dem
