// Speed against error: what each choice of the DEM saves, and what it does to collisions and impacts.
#pragma once

#include <filesystem>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/bench/dem_speed.hpp"

namespace granary::bench {

/// rows of choices[]: choice (time step, stiffness, skin, coarse graining, burst length), value, whether it is the
/// reference, the errors against that with their statistical errors, and core seconds a second of process.
/// Errors: granary-dem fails.
Result<json::Value> choice_rows(Effort effort, const std::filesystem::path& scratch, const Say& say);

}  // namespace granary::bench
