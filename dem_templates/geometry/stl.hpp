// STL files: the walls LIGGGHTS reads. Lengths in metres.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"
#include "dem_templates/geometry/mesh.hpp"

namespace granary::dem {

/// ASCII STL with digits enough that shared vertices stay shared.
std::string stl_text(const Mesh& mesh, const std::string& name);

/// The mesh of an ASCII or binary STL file, vertices at the same place made one.
/// Errors, each naming the file and the place: missing, not an STL, cut short, no triangles, not closed.
Result<Mesh> read_stl(const std::filesystem::path& file);

}  // namespace granary::dem
