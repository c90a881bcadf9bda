#include "dem_templates/plugin/wall/face.hpp"

#include <algorithm>
#include <optional>
#include <tuple>

namespace granary::dem {
namespace {

constexpr double kLeastSine = 1e-3;  // of a corner of a pair: below it two sides are as good as one

/// Two triangles as one face, if they can be one: `a` with its side k, and the corner of `b` off that side.
std::optional<std::array<Vector3, 4>> joined(const Triangle& a, std::size_t k, const Triangle& b, double flat) {
  const Vector3 &start = a[k], &end = a[(k + 1) % 3];
  const auto in_b = std::find(b.begin(), b.end(), end) - b.begin();
  if (in_b == 3 || b[static_cast<std::size_t>(in_b + 1) % 3] != start) return {};  // the other way round
  const Vector3& off = b[static_cast<std::size_t>(in_b + 2) % 3];
  const std::array<Vector3, 4> corner{end, a[(k + 2) % 3], start, off};

  const auto normal = [](const Triangle& t) {
    const Vector3 area = cross(t[1] - t[0], t[2] - t[0]);
    return (1.0 / norm(area)) * area;
  };
  const Vector3 up = normal(a);
  if (std::abs(dot(off - start, up)) > flat || std::abs(dot(corner[1] - start, normal(b))) > flat) return {};
  for (std::size_t c = 0; c < 4; ++c) {
    const Vector3 in = corner[c] - corner[(c + 3) % 4], out = corner[(c + 1) % 4] - corner[c];
    if (dot(cross(in, out), up) < kLeastSine * norm(in) * norm(out)) return {};
  }
  return corner;
}

}  // namespace

void sort_by_ends(std::vector<SharedSide>& sides) {
  std::sort(sides.begin(), sides.end(), [](const SharedSide& a, const SharedSide& b) {
    return std::tie(a.low, a.high, a.owner, a.side) < std::tie(b.low, b.high, b.owner, b.side);
  });
}

std::vector<Face> faces_of(std::span<const Triangle> triangles, double flat) {
  std::vector<SharedSide> sides;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[t][k], triangles[t][(k + 1) % 3]);
      sides.push_back({low, high, t, k});
    }
  sort_by_ends(sides);

  struct Pair {
    double length;
    std::size_t first;  // of the sides
  };
  std::vector<Pair> pairs;
  for (std::size_t s = 0; s + 1 < sides.size(); ++s) {
    const bool two = same_ends(sides[s], sides[s + 1]);
    const bool more = two && ((s > 0 && same_ends(sides[s - 1], sides[s])) ||
                              (s + 2 < sides.size() && same_ends(sides[s + 1], sides[s + 2])));
    if (two && !more) pairs.push_back({norm(sides[s].high - sides[s].low), s});
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.length > b.length; });

  std::vector<std::optional<Face>> face(triangles.size());  // at its first triangle
  std::vector<bool> taken(triangles.size(), false);
  for (const Pair& pair : pairs) {
    const std::uint32_t a = sides[pair.first].owner, b = sides[pair.first + 1].owner;
    if (taken[a] || taken[b]) continue;
    const auto corner = joined(triangles[a], sides[pair.first].side, triangles[b], flat);
    if (!corner) continue;
    taken[a] = taken[b] = true;
    face[std::min(a, b)] = Face{*corner, {a, b}};
  }
  std::vector<Face> faces;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Triangle& corner = triangles[t];
    if (!taken[t]) face[t] = Face{{corner[0], corner[1], corner[2], corner[2]}, {t, t}};
    if (face[t]) faces.push_back(*face[t]);
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
