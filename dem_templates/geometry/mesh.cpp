#include "dem_templates/geometry/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>

#include "common/assert.hpp"

namespace granary::dem {
namespace {

std::string place(Vec3 p) { return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", p.x, p.y, p.z); }

}  // namespace

void append(Mesh& mesh, const Mesh& other) {
  const int shift = static_cast<int>(mesh.vertex.size());
  mesh.vertex.insert(mesh.vertex.end(), other.vertex.begin(), other.vertex.end());
  for (const Corners& t : other.triangle) mesh.triangle.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
}

double volume(const Mesh& mesh) {
  double sum = 0.0;
  for (const Corners& t : mesh.triangle) sum += dot(mesh.vertex[t[0]], cross(mesh.vertex[t[1]], mesh.vertex[t[2]]));
  return sum / 6.0;
}

Mesh refine(const Mesh& mesh, int n) {
  GRANARY_ASSERT(n >= 1, n);
  if (n == 1) return mesh;
  Mesh fine{mesh.vertex, {}};
  std::map<std::array<int, 3>, int> on_edge;  // lower vertex, higher vertex, step from the lower one
  for (const Corners& t : mesh.triangle) {
    // Vertex number of the point with barycentric steps (n - i - j, i, j). Edge points are made once for both
    // triangles.
    const auto edge_point = [&](int a, int b, int step) {
      if (step == 0) return a;
      if (step == n) return b;
      if (a > b) std::swap(a, b), step = n - step;
      const auto [at, is_new] = on_edge.try_emplace({a, b, step}, static_cast<int>(fine.vertex.size()));
      if (is_new)
        fine.vertex.push_back(mesh.vertex[a] + (static_cast<double>(step) / n) * (mesh.vertex[b] - mesh.vertex[a]));
      return at->second;
    };
    std::vector<std::vector<int>> point(n + 1);
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        if (j == 0)
          point[i].push_back(edge_point(t[0], t[1], i));
        else if (i == 0)
          point[i].push_back(edge_point(t[0], t[2], j));
        else if (i + j == n)
          point[i].push_back(edge_point(t[1], t[2], j));
        else {
          point[i].push_back(static_cast<int>(fine.vertex.size()));
          fine.vertex.push_back((1.0 / n) * (static_cast<double>(n - i - j) * mesh.vertex[t[0]] +
                                             static_cast<double>(i) * mesh.vertex[t[1]] +
                                             static_cast<double>(j) * mesh.vertex[t[2]]));
        }
      }
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        fine.triangle.push_back({point[i][j], point[i + 1][j], point[i][j + 1]});
        if (i + j + 1 < n) fine.triangle.push_back({point[i + 1][j], point[i + 1][j + 1], point[i][j + 1]});
      }
  }
  return fine;
}

std::optional<std::string> defect(const Mesh& mesh) {
  if (mesh.triangle.empty()) return "it has no triangles";
  std::map<std::pair<int, int>, int> directed;  // how many triangles run along this edge in this direction
  for (std::size_t n = 0; n < mesh.triangle.size(); ++n) {
    const Corners& t = mesh.triangle[n];
    const Vec3 a = mesh.vertex[t[0]], b = mesh.vertex[t[1]], c = mesh.vertex[t[2]];
    const double longest = std::max({length(b - a), length(c - b), length(a - c)});
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0] || !(length(cross(b - a, c - a)) > 1e-9 * longest * longest))
      return fmt::format("triangle {} at {} has no area", n + 1, place(a));
    for (int k = 0; k < 3; ++k) ++directed[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : directed) {
    const auto back = directed.find({edge.second, edge.first});
    const int other_way = back == directed.end() ? 0 : back->second;
    if (count == 1 && other_way == 1) continue;
    const std::string where =
        fmt::format("the edge from {} to {}", place(mesh.vertex[edge.first]), place(mesh.vertex[edge.second]));
    if (count + other_way == 1) return where + " belongs to one triangle only: there is a hole";
    if (count == 2 && other_way == 0) return where + " joins two triangles that look to opposite sides";
    return fmt::format("{} belongs to {} triangles", where, count + other_way);
  }
  return std::nullopt;
}

Mesh weld(const Mesh& mesh, double tolerance) {
  using Cell = std::array<std::int64_t, 3>;
  const auto cell_of = [&](Vec3 p) {
    return Cell{std::llround(p.x / tolerance), std::llround(p.y / tolerance), std::llround(p.z / tolerance)};
  };
  Mesh welded;
  std::map<Cell, std::vector<int>> cells;
  std::vector<int> now(mesh.vertex.size());
  for (std::size_t n = 0; n < mesh.vertex.size(); ++n) {
    const Vec3 p = mesh.vertex[n];
    const Cell home = cell_of(p);
    int found = -1;
    for (int dx = -1; dx <= 1 && found < 0; ++dx)
      for (int dy = -1; dy <= 1 && found < 0; ++dy)
        for (int dz = -1; dz <= 1 && found < 0; ++dz) {
          const auto there = cells.find({home[0] + dx, home[1] + dy, home[2] + dz});
          if (there == cells.end()) continue;
          for (int candidate : there->second)
            if (length(welded.vertex[candidate] - p) <= tolerance) found = candidate;
        }
    if (found < 0) {
      found = static_cast<int>(welded.vertex.size());
      welded.vertex.push_back(p);
      cells[home].push_back(found);
    }
    now[n] = found;
  }
  for (const Corners& t : mesh.triangle) welded.triangle.push_back({now[t[0]], now[t[1]], now[t[2]]});
  return welded;
}

Box3 bounding_box(const Mesh& mesh) {
  const double inf = std::numeric_limits<double>::infinity();
  Box3 box{{inf, inf, inf}, {-inf, -inf, -inf}};
  for (Vec3 p : mesh.vertex) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

}  // namespace granary::dem
