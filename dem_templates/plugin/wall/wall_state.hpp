// The bodies' part of a restart file, as text: a line each.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "dem_templates/plugin/wall/wall_body.hpp"

namespace granary::dem {

std::string wall_state(const std::vector<WallBody>& bodies);

/// Sets the bodies' angles. Error: the state is of other bodies than these; none is changed then.
Status set_wall_state(const std::string& state, std::vector<WallBody>& bodies);

}  // namespace granary::dem
