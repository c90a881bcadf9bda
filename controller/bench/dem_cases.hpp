// The machines, fillings and settings that the bench of the DEM measures.
#pragma once

#include <utility>
#include <vector>

#include "dem_templates/case/dem_case.hpp"

namespace granary::bench {

/// A diameter [m] and how many particles have it.
using Fill = std::vector<std::pair<double, long>>;

/// The closed horizontal mixer, turning once in `turn` [s]: nothing leaves, so that a state can be measured at leisure.
dem::DemCase mixer_case(const Fill& fill, double turn = 0.03, int refinement = 1);
/// The batch bowl: impeller 1200 rpm, chopper 3000 rpm.
dem::DemCase bowl_case(const Fill& fill);

/// The closed mixer of the ten seconds: 2300 particles of 4 mm; its step and duration are left to the caller.
dem::DemCase ten_seconds_mixer();

/// The mixer at work: 15 kg/h fed, the outlet open.
dem::DemCase working_mixer(const Fill& fill);

/// One window, and so one batch, a turn of the impeller.
double turn_of(const dem::DemCase& dem_case);

}  // namespace granary::bench
