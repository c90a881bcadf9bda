// The machine's bodies as LIGGGHTS commands: our granary/wall, or LIGGGHTS' own walls.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "dem_templates/case/dem_case.hpp"
#include "dem_templates/geometry/machine.hpp"

namespace granary::dem {

/// Defines the walls and how they turn.
Result<std::string> wall_commands(const DemCase& dem_case, const std::vector<Body>& all);

/// Where the walls are LIGGGHTS' own, walls of ours that see each impact as it begins, and push nobody: only
/// granary-dem knows these. After wall_commands(), at the same step.
std::string watching_walls(const DemCase& dem_case, const std::vector<Body>& all);

/// Keywords of granary/resize: what it keeps particles off.
std::string resize_walls(const DemCase& dem_case, const std::vector<Body>& all);

/// Keywords of granary/tally: the bodies whose impacts it counts, of wall_commands() or watching_walls().
std::string tally_bodies(const DemCase& dem_case, const std::vector<Body>& all);

/// " rolling_friction epsd2" where there is some.
std::string rolling_style(const DemCase& dem_case);

}  // namespace granary::dem
