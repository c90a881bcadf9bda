#include "common/stl.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>

#include "common/files.hpp"

namespace granary {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");
constexpr std::size_t kHeader = 80, kFacet = 50;

std::uint32_t facet_count(std::string_view bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kHeader + 4) std::memcpy(&count, bytes.data() + kHeader, 4);
  return count;
}

std::size_t binary_size(std::string_view bytes) { return kHeader + 4 + kFacet * std::size_t{facet_count(bytes)}; }

// Many binary files also begin with "solid": the length decides.
bool is_binary(std::string_view bytes) { return bytes.size() >= kHeader + 4 && bytes.size() == binary_size(bytes); }

std::vector<StlTriangle> parse_binary(std::string_view bytes) {
  std::vector<StlTriangle> triangles(facet_count(bytes));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    float number[12];  // normal, then three corners
    std::memcpy(number, bytes.data() + kHeader + 4 + kFacet * t, sizeof number);
    for (std::size_t k = 0; k < 9; ++k) triangles[t][k / 3][k % 3] = static_cast<double>(number[3 + k]);
  }
  return triangles;
}

Result<std::vector<StlTriangle>> parse_ascii(const std::string& text, const std::string& file) {
  std::vector<StlTriangle> triangles;
  std::istringstream lines(text);
  std::string line, word;
  StlTriangle corners{};
  std::size_t n_line = 0, n_corners = 0;
  bool ended = false;
  while (std::getline(lines, line)) {
    ++n_line;
    std::istringstream words(line);
    if (!(words >> word)) continue;
    if (word == "vertex") {
      std::array<double, 3> p{};
      if (!(words >> p[0] >> p[1] >> p[2]))
        return Error{fmt::format("{}: line {}: \"{}\" is not a vertex with three numbers.", file, n_line, line)};
      if (n_corners == 3)
        return Error{fmt::format("{}: line {}: a facet with more than three vertices.", file, n_line)};
      corners[n_corners++] = p;
    } else if (word == "endfacet") {
      if (n_corners != 3)
        return Error{
            fmt::format("{}: line {}: a facet with {} vertices; it must have three.", file, n_line, n_corners)};
      triangles.push_back(corners);
      n_corners = 0;
    } else if (word == "endsolid") {
      ended = true;
    }
  }
  if (n_corners != 0 || !ended)
    return Error{
        fmt::format("{}: ends at line {} before \"endsolid\": the file was cut. Export it again.", file, n_line)};
  return triangles;
}

bool is_finite(const StlTriangle& triangle) {
  return std::all_of(triangle.begin(), triangle.end(), [](const auto& p) { return std::isfinite(p[0] + p[1] + p[2]); });
}

}  // namespace

Result<std::vector<StlTriangle>> read_stl_triangles(const std::filesystem::path& file) {
  const std::string name = file.string();
  if (!std::filesystem::is_regular_file(file))
    return Error{fmt::format("{}: no such file. It should be an STL mesh in metres.", name)};
  GRANARY_TRY(const std::string bytes, read_text(file));
  std::vector<StlTriangle> triangles;
  if (is_binary(bytes)) {
    triangles = parse_binary(bytes);
  } else if (bytes.starts_with("solid")) {
    GRANARY_TRY(triangles, parse_ascii(bytes, name));
  } else {
    return Error{
        fmt::format("{}: not an STL file: it neither begins with \"solid\" nor has the length of a binary one "
                    "({} triangles would take {} bytes, it has {}).",
                    name, facet_count(bytes), binary_size(bytes), bytes.size())};
  }
  if (triangles.empty()) return Error{fmt::format("{}: has no triangles.", name)};
  if (!std::all_of(triangles.begin(), triangles.end(), is_finite))
    return Error{fmt::format("{}: has a vertex that is not a number. Export it again.", name)};
  return triangles;
}

}  // namespace granary
