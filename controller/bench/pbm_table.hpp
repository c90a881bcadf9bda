// The document of the bench as tables to read.
#pragma once

#include <string>

#include "common/json/value.hpp"

namespace granary::bench {

/// @param document  of run_pbm_bench()
std::string pbm_table(const json::Value& document);

/// Seconds with a unit that fits: "72.1 us", "1.50 ms", "2.4 s"; "-" for null.
std::string duration_text(const json::Value& seconds);

}  // namespace granary::bench
