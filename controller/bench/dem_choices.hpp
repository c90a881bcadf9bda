// Speed against error: what each choice of the DEM saves, and what it does to collisions and impacts.
#pragma once

#include <filesystem>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/bench/dem_speed.hpp"

namespace granary::bench {

/// rows of choices[]: choice (time step, stiffness, skin, coarse graining, settling after the fill, ranks and how they
/// cut the mixer, burst length), value, whether it is the reference, the errors against that with their statistical
/// errors, and seconds a second of process takes.
/// Errors: granary-dem fails.
Result<json::Value> choice_rows(Effort effort, const std::filesystem::path& scratch, const Say& say);

}  // namespace granary::bench
