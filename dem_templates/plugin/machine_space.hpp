// The free space of a machine in LIGGGHTS: a region, less what its meshes take.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "dem_templates/plugin/resize/free_space.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace granary::dem {

/// Centres must lie in the region and keep their radius from its surface and from all triangles of these mesh/surface
/// fixes and of all bodies of these granary/wall fixes, as they stand now. reach: the largest distance that will be
/// asked for [m]. All ranks call it and get the same space. Error: no such region, mesh or walls.
Result<std::unique_ptr<FreeSpace>> machine_space(LAMMPS_NS::LAMMPS& lammps, const std::string& region,
                                                 const std::vector<std::string>& meshes,
                                                 const std::vector<std::string>& walls, double reach);

}  // namespace granary::dem
