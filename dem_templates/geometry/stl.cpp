#include "dem_templates/geometry/stl.hpp"

#include <fmt/format.h>

#include "common/stl.hpp"

namespace granary::dem {
namespace {

// Each triangle with corners of its own.
Mesh mesh_of(const std::vector<StlTriangle>& triangles) {
  Mesh mesh;
  for (const StlTriangle& corners : triangles) {
    const int first = static_cast<int>(mesh.vertex.size());
    for (const auto& p : corners) mesh.vertex.push_back({p[0], p[1], p[2]});
    mesh.triangle.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

}  // namespace

std::string stl_text(const Mesh& mesh, const std::string& name) {
  std::string text = fmt::format("solid {}\n", name);
  for (const Corners& t : mesh.triangle) {
    const Vec3 a = mesh.vertex[t[0]], b = mesh.vertex[t[1]], c = mesh.vertex[t[2]];
    const Vec3 area = cross(b - a, c - a);
    const Vec3 normal = (1.0 / length(area)) * area;
    text += fmt::format("facet normal {:.9e} {:.9e} {:.9e}\n outer loop\n", normal.x, normal.y, normal.z);
    for (Vec3 p : {a, b, c}) text += fmt::format("  vertex {:.12e} {:.12e} {:.12e}\n", p.x, p.y, p.z);
    text += " endloop\nendfacet\n";
  }
  return text + fmt::format("endsolid {}\n", name);
}

Result<Mesh> read_stl(const std::filesystem::path& file) {
  GRANARY_TRY(const std::vector<StlTriangle> triangles, read_stl_triangles(file));
  Mesh mesh = mesh_of(triangles);
  const Box3 box = bounding_box(mesh);
  mesh = weld(mesh, 1e-6 * length(box.high - box.low));
  if (const auto fault = defect(mesh))
    return Error{fmt::format("{}: not watertight: {}. Close the body in the CAD program and export it again.",
                             file.string(), *fault)};
  return mesh;
}

}  // namespace granary::dem
