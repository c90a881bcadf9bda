// The triangles of an STL file, as they stand in it. Whether they make a body is for the reader's user to ask.
#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "common/result.hpp"

namespace granary {

using StlTriangle = std::array<std::array<double, 3>, 3>;

/// ASCII or binary; lengths as they stand in the file. At least one triangle; all numbers finite.
/// Errors, each naming the file and the place: missing, not an STL, cut short, a vertex that is no number, no
/// triangles.
Result<std::vector<StlTriangle>> read_stl_triangles(const std::filesystem::path& file);

}  // namespace granary
