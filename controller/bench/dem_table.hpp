// The document of the DEM's bench as tables to read.
#pragma once

#include <string>

#include "common/json/value.hpp"

namespace granary::bench {

/// @param document  of run_dem_bench()
std::string dem_table(const json::Value& document);

}  // namespace granary::bench
