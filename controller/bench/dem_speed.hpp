// Time per step: stock LIGGGHTS and granary-dem in turn, on the same case from the same state.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "controller/bench/effort.hpp"

namespace granary::bench {

using Say = std::function<void(const std::string&)>;

/// rows of speed[]: case, particles, impeller_triangles, ranks, stock_ms_per_step, granary_ms_per_step, ratio, ... as
/// docs/dem_bench.md tells. Errors: a program fails; there is no liggghts.
Result<json::Value> speed_rows(Effort effort, const std::filesystem::path& scratch, const Say& say);

/// tally_overhead, restart_overhead and process (10 s of the mixer at work).
Result<json::Value> overheads(Effort effort, const std::filesystem::path& scratch, const Say& say);

}  // namespace granary::bench
