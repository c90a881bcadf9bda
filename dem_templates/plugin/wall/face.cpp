#include "dem_templates/plugin/wall/face.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

namespace granary::dem {
namespace {

constexpr double kLeastSine = 1e-3;  // of a corner of a pair: below it two sides are as good as one

double area_of(const Triangle& t) { return 0.5 * norm(cross(t[1] - t[0], t[2] - t[0])); }

/// Two triangles of one plane as one face, if it is convex: `a` with its side k, and the corner of `b` off that side.
std::optional<std::array<Vector3, 4>> joined(const Triangle& a, std::size_t k, const Triangle& b) {
  const Vector3 &start = a[k], &end = a[(k + 1) % 3];
  const auto in_b = std::find(b.begin(), b.end(), end) - b.begin();
  const std::array<Vector3, 4> corner{end, a[(k + 2) % 3], start, b[static_cast<std::size_t>(in_b + 2) % 3]};
  for (std::size_t c = 0; c < 4; ++c) {
    const Vector3 in = corner[c] - corner[(c + 3) % 4], out = corner[(c + 1) % 4] - corner[c];
    if (dot(cross(in, out), unit_normal(a)) < kLeastSine * norm(in) * norm(out)) return {};
  }
  return corner;
}

}  // namespace

void sort_by_ends(std::vector<SharedSide>& sides) {
  std::sort(sides.begin(), sides.end(), [](const SharedSide& a, const SharedSide& b) {
    return std::tie(a.low, a.high, a.owner, a.side) < std::tie(b.low, b.high, b.owner, b.side);
  });
}

namespace {

struct Joint {
  std::uint32_t a, b;    // triangles of one plane
  std::uint32_t side_a;  // the shared one, of a
  double length;
};

/// Sides that two triangles of one plane share, and no third one.
std::vector<Joint> joints_of(std::span<const Triangle> triangles, double flat) {
  std::vector<SharedSide> sides;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
      sides.push_back({low, high, t, k});
    }
  sort_by_ends(sides);
  std::vector<Joint> joints;
  for (std::size_t s = 0; s + 1 < sides.size(); ++s) {
    const bool two = same_ends(sides[s], sides[s + 1]);
    const bool more = two && ((s > 0 && same_ends(sides[s - 1], sides[s])) ||
                              (s + 2 < sides.size() && same_ends(sides[s + 1], sides[s + 2])));
    if (!two || more) continue;
    const Triangle &a = triangles[sides[s].owner], &b = triangles[sides[s + 1].owner];
    if (a[sides[s].side] == b[sides[s + 1].side]) continue;  // the other way round
    const Vector3 &start = a[sides[s].side], &off_a = a[(sides[s].side + 2) % 3],
                  &off_b = b[(sides[s + 1].side + 2) % 3];
    if (std::abs(dot(off_b - start, unit_normal(a))) > flat || std::abs(dot(off_a - start, unit_normal(b))) > flat)
      continue;
    if (dot(unit_normal(a), unit_normal(b)) < 0.0) continue;  // folded back
    joints.push_back({sides[s].owner, sides[s + 1].owner, sides[s].side, norm(sides[s].high - sides[s].low)});
  }
  return joints;
}

/// Of each triangle the number of the first one that it hangs together with.
std::vector<std::uint32_t> regions_of(std::size_t n_triangles, const std::vector<Joint>& joints) {
  std::vector<std::uint32_t> first(n_triangles);
  std::iota(first.begin(), first.end(), 0u);
  const auto find = [&first](std::uint32_t t) {
    while (first[t] != t) t = first[t] = first[first[t]];
    return t;
  };
  for (const Joint& joint : joints) {
    const std::uint32_t a = find(joint.a), b = find(joint.b);
    first[std::max(a, b)] = std::min(a, b);
  }
  for (std::uint32_t t = 0; t < n_triangles; ++t) first[t] = find(t);
  return first;
}

/// The corners around triangles of one plane, counterclockwise; none where they have holes or touch at a corner only.
std::vector<Vector3> outline(std::span<const Triangle> triangles, const std::vector<std::uint32_t>& region) {
  std::set<std::pair<Vector3, Vector3>> sides;  // that are not shared
  for (const std::uint32_t t : region)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 &from = triangles[t][k], &to = triangles[t][(k + 1) % 3];
      if (sides.erase({to, from}) == 0) sides.insert({from, to});
    }
  std::map<Vector3, Vector3> next(sides.begin(), sides.end());
  if (next.empty() || next.size() != sides.size()) return {};
  std::vector<Vector3> corners{next.begin()->first};
  for (auto at = next.find(next.begin()->second); at != next.end() && at->first != corners[0];
       at = next.find(at->second))
    corners.push_back(at->first);
  return corners.size() == next.size() ? corners : std::vector<Vector3>{};
}

/// Triangles that hang together in one plane, as one face, if they are one.
std::optional<Face> whole(std::span<const Triangle> triangles, const std::vector<std::uint32_t>& region, double flat) {
  const std::vector<Vector3> around = outline(triangles, region);
  const std::size_t n = around.size();
  const Vector3 up = n > 0 ? unit_normal(triangles[region[0]]) : Vector3{};
  std::vector<Vector3> corner;
  for (std::size_t k = 0; k < n; ++k) {
    const Vector3 in = around[k] - around[(k + n - 1) % n], out = around[(k + 1) % n] - around[k];
    const double turn = dot(cross(in, out), up), chord = norm(in + out);
    if (std::abs(turn) <= flat * chord && dot(in, out) > 0.0) continue;  // straight on
    if (turn < kLeastSine * norm(in) * norm(out) || corner.size() == 4) return {};
    corner.push_back(around[k]);
  }
  if (corner.size() < 3) return {};

  // Small bends add up: held against what has become of it.
  double area = 0.0;
  for (const std::uint32_t t : region) area += area_of(triangles[t]);
  if (corner.size() == 3) corner.push_back(corner[2]);
  const double whole_area = area_of({corner[0], corner[1], corner[2]}) + area_of({corner[0], corner[2], corner[3]});
  if (std::abs(area - whole_area) > 1e-6 * area) return {};
  const Vector3 normal = unit_normal({corner[0], corner[1], corner[2]});
  for (const Vector3& point : around) {
    double off = std::numeric_limits<double>::max();  // the nearest side
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3 along = corner[(k + 1) % 4] - corner[k];
      const double length = norm(along);
      if (length > 0.0) off = std::min(off, norm(cross(along, point - corner[k])) / length);
    }
    if (off > flat) return {};
  }
  for (const std::uint32_t t : region)
    for (const Vector3& point : triangles[t])
      if (std::abs(dot(point - corner[0], normal)) > flat) return {};
  return Face{{corner[0], corner[1], corner[2], corner[3]}, region};
}

}  // namespace

std::vector<Face> faces_of(std::span<const Triangle> triangles, double flat) {
  std::vector<Joint> joints = joints_of(triangles, flat);
  const std::vector<std::uint32_t> first = regions_of(triangles.size(), joints);
  std::vector<std::vector<std::uint32_t>> region(triangles.size());  // at its first triangle
  for (std::uint32_t t = 0; t < triangles.size(); ++t) region[first[t]].push_back(t);

  std::vector<std::optional<Face>> face(triangles.size());  // at its first triangle
  std::vector<bool> taken(triangles.size(), false);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (region[t].size() < 2) continue;
    face[t] = whole(triangles, region[t], flat);
    if (!face[t]) continue;
    for (const std::uint32_t part : region[t]) taken[part] = true;
  }
  std::stable_sort(joints.begin(), joints.end(), [](const Joint& a, const Joint& b) { return a.length > b.length; });
  for (const Joint& joint : joints) {
    if (taken[joint.a] || taken[joint.b]) continue;
    const auto corner = joined(triangles[joint.a], joint.side_a, triangles[joint.b]);
    if (!corner) continue;
    taken[joint.a] = taken[joint.b] = true;
    face[std::min(joint.a, joint.b)] = Face{*corner, {joint.a, joint.b}};
  }
  std::vector<Face> faces;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Triangle& corner = triangles[t];
    if (!taken[t]) face[t] = Face{{corner[0], corner[1], corner[2], corner[2]}, {t}};
    if (face[t]) faces.push_back(std::move(*face[t]));
  }
  return faces;
}

Vector3 nearest_point(const Face& face, const Vector3& p) {
  const auto& corner = face.corner;
  const Vector3 first = nearest_point(Triangle{corner[0], corner[1], corner[2]}, p);
  if (face.is_triangle()) return first;
  const Vector3 second = nearest_point(Triangle{corner[0], corner[2], corner[3]}, p);
  return norm(p - second) < norm(p - first) ? second : first;
}

}  // namespace granary::dem
