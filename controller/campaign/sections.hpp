// The sections of a workflow: each function reads one into the campaign, adding to the problems what is wrong with it.
// Private to controller/campaign. Keys, units, defaults: docs/workflow_format.md. Rules between sections: checks.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "common/json/reader.hpp"
#include "controller/campaign/campaign.hpp"

namespace granary::campaign {

/// A section that may be missing: then it reads as {}, so that every setting takes its default.
json::Reader section_or_empty(json::Reader& reader, const std::string& key, json::Problems& problems);

/// `"bins": 16` or `"bins": [16, 24]`: one value for both solids, or one each.
std::array<int, 2> integer_pair_or(json::Reader& reader, const std::string& key, std::array<int, 2> otherwise,
                                   json::Range range, json::Problems& problems);
std::array<double, 2> number_pair_or(json::Reader& reader, const std::string& key, std::array<double, 2> otherwise,
                                     json::Range range, json::Problems& problems);
std::array<double, 2> quantity_pair_or(json::Reader& reader, const std::string& key, std::array<double, 2> otherwise,
                                       const std::string& si_unit, json::Range range, json::Problems& problems);

/// A message with its file's name as the workflow has it: relative to the workflow's folder.
std::string without_folder(std::string message, const std::filesystem::path& folder);

/// LIGGGHTS' insertion takes only prime seeds above 10000, and says so only once it runs: the first from there on.
std::int64_t next_seed(std::int64_t from);
constexpr std::int64_t kLargestSeed = 2147483647;

/// Whether a setting is left out or says "auto"; it then counts as read.
bool is_auto(json::Reader& reader, const std::string& key);

void read_materials(json::Reader& root, Campaign& campaign, json::Problems& problems);
void read_machine(json::Reader& root, Campaign& campaign, json::Problems& problems);
void read_pbm(json::Reader& root, Campaign& campaign, json::Problems& problems);
/// feed, charge, process, spray: what is in the machine and what goes in. After materials, machine and pbm (the grid).
void read_process(json::Reader& root, Campaign& campaign, json::Problems& problems);
void read_dem(json::Reader& root, Campaign& campaign, json::Problems& problems);
void read_coupling(json::Reader& root, Campaign& campaign, json::Problems& problems);
/// After all of the above: its experiments are the workflow with other settings.
void read_estimation(json::Reader& root, Campaign& campaign, json::Problems& problems);
/// sweep: solver, settings, and the values of each case (none of them understood yet).
void read_sweep(json::Reader& root, Campaign& campaign, json::Problems& problems);
/// process and agglomerates of a DEM by itself. After machine and dem.
void read_dem_alone(json::Reader& root, Campaign& campaign, json::Problems& problems);
/// resources, outputs, cost_model: also of kinds tasks and sweep.
void read_running(json::Reader& root, Campaign& campaign, json::Problems& problems);

}  // namespace granary::campaign
