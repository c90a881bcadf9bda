// The triangles of an STL file. Unlike those of a machine's case, these walls need not be closed bodies.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "dem_templates/plugin/resize/triangles.hpp"

namespace granary::dem {

/// ASCII or binary; lengths as they stand in the file [m]. Triangles without area are left out.
/// Errors, each naming the file: missing, not an STL, cut short, a vertex that is no number, no triangles.
Result<std::vector<Triangle>> read_stl_triangles(const std::string& file);

}  // namespace granary::dem
