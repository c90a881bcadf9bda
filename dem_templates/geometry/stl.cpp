#include "dem_templates/geometry/stl.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string_view>

#include "common/files.hpp"

namespace granary::dem {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");
constexpr std::size_t kHeader = 80, kFacet = 50;

void add_triangle(Mesh& mesh, const std::array<Vec3, 3>& corner) {
  const int first = static_cast<int>(mesh.vertex.size());
  mesh.vertex.insert(mesh.vertex.end(), corner.begin(), corner.end());
  mesh.triangle.push_back({first, first + 1, first + 2});
}

std::uint32_t facet_count(std::string_view bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kHeader + 4) std::memcpy(&count, bytes.data() + kHeader, 4);
  return count;
}

// Many binary files also begin with "solid": the length decides.
bool is_binary(std::string_view bytes) {
  return bytes.size() >= kHeader + 4 && bytes.size() == kHeader + 4 + kFacet * std::size_t{facet_count(bytes)};
}

Mesh parse_binary(std::string_view bytes) {
  Mesh mesh;
  for (std::uint32_t n = 0; n < facet_count(bytes); ++n) {
    float number[12];  // normal, then three corners
    std::memcpy(number, bytes.data() + kHeader + 4 + kFacet * n, sizeof number);
    add_triangle(mesh, {Vec3{number[3], number[4], number[5]}, Vec3{number[6], number[7], number[8]},
                        Vec3{number[9], number[10], number[11]}});
  }
  return mesh;
}

Result<Mesh> parse_ascii(const std::string& text, const std::string& file) {
  Mesh mesh;
  std::istringstream lines(text);
  std::string line, word;
  std::array<Vec3, 3> corner;
  int n_line = 0, n_corners = 0;
  bool ended = false;
  while (std::getline(lines, line)) {
    ++n_line;
    std::istringstream words(line);
    if (!(words >> word)) continue;
    if (word == "vertex") {
      Vec3 p;
      if (!(words >> p.x >> p.y >> p.z))
        return Error{fmt::format("{}: line {}: \"{}\" is not a vertex with three numbers.", file, n_line, line)};
      if (n_corners == 3)
        return Error{fmt::format("{}: line {}: a facet with more than three vertices.", file, n_line)};
      corner[n_corners++] = p;
    } else if (word == "endfacet") {
      if (n_corners != 3)
        return Error{
            fmt::format("{}: line {}: a facet with {} vertices; it must have three.", file, n_line, n_corners)};
      add_triangle(mesh, corner);
      n_corners = 0;
    } else if (word == "endsolid") {
      ended = true;
    }
  }
  if (n_corners != 0 || !ended)
    return Error{
        fmt::format("{}: ends at line {} before \"endsolid\": the file was cut. Export it again.", file, n_line)};
  return mesh;
}

}  // namespace

std::string stl_text(const Mesh& mesh, const std::string& name) {
  std::string text = fmt::format("solid {}\n", name);
  for (const Triangle& t : mesh.triangle) {
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
  const std::string name = file.string();
  if (!std::filesystem::is_regular_file(file))
    return Error{fmt::format("{}: no such file. It should be an STL mesh in metres.", name)};
  GRANARY_TRY(const std::string bytes, read_text(file));
  const bool binary = is_binary(bytes);
  if (!binary && !bytes.starts_with("solid"))
    return Error{
        fmt::format("{}: not an STL file: it neither begins with \"solid\" nor has the length of a binary one "
                    "({} triangles would take {} bytes, it has {}).",
                    name, facet_count(bytes), kHeader + 4 + kFacet * std::size_t{facet_count(bytes)}, bytes.size())};
  Mesh mesh;
  if (binary) {
    mesh = parse_binary(bytes);
  } else {
    GRANARY_TRY(mesh, parse_ascii(bytes, name));
  }
  if (mesh.triangle.empty()) return Error{fmt::format("{}: has no triangles.", name)};
  const Box3 box = bounding_box(mesh);
  const double size = length(box.high - box.low);
  if (!std::isfinite(size)) return Error{fmt::format("{}: has a vertex that is not a number.", name)};
  mesh = weld(mesh, 1e-6 * size);
  if (const auto fault = defect(mesh))
    return Error{
        fmt::format("{}: not watertight: {}. Close the body in the CAD program and export it again.", name, *fault)};
  return mesh;
}

}  // namespace granary::dem
