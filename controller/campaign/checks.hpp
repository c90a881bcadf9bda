// Rules between settings that are each fine by themselves. Private to controller/campaign.
#pragma once

#include "common/json/problems.hpp"
#include "controller/campaign/campaign.hpp"

namespace granary::campaign {

/// Adds what does not fit together. A rule over a setting that already has a problem is left out: its value is only a
/// default.
void check_together(const Campaign& campaign, json::Problems& problems);

/// The same for a case of a sweep whose solver is the DEM.
void check_dem_alone(const Campaign& campaign, json::Problems& problems);

/// The DEM's base case takes the time step of likely particles where it is "auto": each burst chooses its own later.
void choose_likely_time_step(Campaign& campaign);

/// Whether every task fits on so many nodes of so many cores.
void check_cores(const Campaign& campaign, int nodes, int cores_per_node, json::Problems& problems);

}  // namespace granary::campaign
