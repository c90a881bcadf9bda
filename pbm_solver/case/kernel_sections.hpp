// The sections of a case that say how often particles meet, aggregate and break, between JSON and PbmCase. Problems
// go to the reader.
#pragma once

#include <optional>

#include "common/json/reader.hpp"
#include "pbm_solver/case/pbm_case.hpp"

namespace granary::pbm {

DemRates read_dem(json::Reader reader, const Compartments& row);
Aggregation read_aggregation(json::Reader reader, const std::optional<DemRates>& dem);
Breakage read_breakage(json::Reader reader, const std::optional<DemRates>& dem);

json::Value dem_json(const DemRates& dem);
json::Value aggregation_json(const Aggregation& aggregation);
json::Value breakage_json(const Breakage& breakage);

}  // namespace granary::pbm
