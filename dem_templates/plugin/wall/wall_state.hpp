// The bodies' part of a restart file, as text: a line each, and one for its wear if it has any.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "dem_templates/plugin/wall/wall_body.hpp"
#include "dem_templates/plugin/wall/wear.hpp"

namespace granary::dem {

/// wear: of each body, or nothing.
std::string wall_state(const std::vector<WallBody>& bodies, const std::vector<Wear>& wear);

/// Sets the bodies' angles, and their wear if there is any in the state and any is wanted. Error: the state is of other
/// bodies than these; none is changed then.
Status set_wall_state(const std::string& state, std::vector<WallBody>& bodies, std::vector<Wear>& wear);

}  // namespace granary::dem
