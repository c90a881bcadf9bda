// The figures of `granary bench pilot` as a table to read, beside what was aimed at.
#pragma once

#include <string>

#include "common/json/value.hpp"

namespace granary::bench {

/// @param document  as --json prints it; parts that were not run are left out
std::string pilot_table(const json::Value& document);

}  // namespace granary::bench
