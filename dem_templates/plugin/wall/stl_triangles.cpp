#include "dem_templates/plugin/wall/stl_triangles.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <sstream>

#include "common/files.hpp"
#include "dem_templates/plugin/wall/vectors.hpp"

namespace granary::dem {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");
constexpr std::size_t kHeader = 84, kFacet = 50;

std::uint32_t facet_count(const std::string& bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeader - 4, 4);
  return count;
}

// Many binary files also begin with "solid": the length decides.
bool is_binary(const std::string& bytes) {
  return bytes.size() >= kHeader && bytes.size() == kHeader + kFacet * std::size_t{facet_count(bytes)};
}

std::vector<Triangle> parse_binary(const std::string& bytes) {
  std::vector<Triangle> triangles(facet_count(bytes));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    float number[12];  // normal, then three corners
    std::memcpy(number, bytes.data() + kHeader + kFacet * t, sizeof number);
    for (std::size_t k = 0; k < 9; ++k) triangles[t][k / 3][k % 3] = static_cast<double>(number[3 + k]);
  }
  return triangles;
}

Result<std::vector<Triangle>> parse_ascii(const std::string& bytes, const std::string& file) {
  const auto fault = [&](int line, const std::string& what) {
    return Error{file + ": line " + std::to_string(line) + ": " + what + " Export the mesh again."};
  };
  std::vector<Triangle> triangles;
  std::istringstream lines(bytes);
  std::string line, word;
  Triangle corners{};
  std::size_t n_corners = 0;
  int n_line = 0;
  bool ended = false;
  while (std::getline(lines, line)) {
    ++n_line;
    std::istringstream words(line);
    if (!(words >> word)) continue;
    if (word == "vertex") {
      Vector3 p{};
      if (!(words >> p[0] >> p[1] >> p[2])) return fault(n_line, "'" + line + "' is not a vertex with three numbers.");
      if (n_corners == 3) return fault(n_line, "a facet with more than three vertices.");
      corners[n_corners++] = p;
    } else if (word == "endfacet") {
      if (n_corners != 3) return fault(n_line, "a facet without three vertices.");
      triangles.push_back(corners);
      n_corners = 0;
    }
    ended = word == "endsolid";
  }
  if (!ended) return fault(n_line, "the file ends before 'endsolid': it was cut.");
  return triangles;
}

}  // namespace

Result<std::vector<Triangle>> read_stl_triangles(const std::string& file) {
  GRANARY_TRY(const std::string bytes, read_text(file));
  const bool binary = is_binary(bytes);
  if (!binary && !bytes.starts_with("solid"))
    return Error{file + ": not an STL file: it neither begins with 'solid' nor has the length of a binary one."};
  std::vector<Triangle> triangles;
  if (binary) {
    triangles = parse_binary(bytes);
  } else {
    GRANARY_TRY(triangles, parse_ascii(bytes, file));
  }
  for (const Triangle& triangle : triangles)
    for (const Vector3& corner : triangle)
      if (!std::isfinite(corner[0] + corner[1] + corner[2]))
        return Error{file + ": has a vertex that is not a number. Export the mesh again."};
  std::erase_if(triangles, [](const Triangle& t) { return norm(cross(t[1] - t[0], t[2] - t[0])) == 0.0; });
  if (triangles.empty()) return Error{file + ": has no triangles."};
  return triangles;
}

}  // namespace granary::dem
