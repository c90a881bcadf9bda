// The machines' regions as LIGGGHTS commands.
#pragma once

#include <string>

#include "common/result.hpp"
#include "dem_templates/case/dem_case.hpp"
#include "dem_templates/geometry/machine.hpp"

namespace granary::dem {

/// Defines region `space`, in which whole particles must lie when granary/resize puts them in: inside of the vessel,
/// outside of shafts and hubs. (It keeps off the triangles of the meshes by itself.)
std::string space_commands(const Machine& machine);

/// The outlet of the horizontal mixer: region and fix.
Result<std::string> outlet_commands(const HorizontalMixer& mixer);

/// Particles fed into the mixer's chute.
Result<std::string> feed_commands(const DemCase& dem_case);

}  // namespace granary::dem
