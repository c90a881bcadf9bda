// Core use of a coupled campaign at the source paper's scale, with and without fillers: the real pilot on a virtual
// clock.
#pragma once

#include <filesystem>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::bench {

/// [{dem_cores, pbm_cores, core_use_off, core_use_on, slowdown, evaluation_core_s}]: 256 cores, four rounds of a DEM
/// burst of 600 s and a PBM burst of 300 s; fillers of 3 s on one core each. `dir`: to work in.
Result<json::Value> simulate_filling(const std::filesystem::path& dir);

}  // namespace granary::bench
