// The bench of the DEM as one document. docs/dem_bench.md has its members.
#pragma once

#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/bench/dem_speed.hpp"
#include "controller/bench/effort.hpp"

namespace granary::bench {

/// @param parts  some of "speed", "overheads", "comparison", "choices"; empty: all
/// Errors: a program is missing (names the package) or fails; an unknown part.
Result<json::Value> run_dem_bench(Effort effort, const std::vector<std::string>& parts, const Say& say);

}  // namespace granary::bench
