// How a campaign went, in a table for people and as JSON for programs.
#pragma once

#include <filesystem>
#include <string>

#include "common/json/value.hpp"
#include "common/results/campaign_results.hpp"
#include "pilot/pilot.hpp"

namespace granary::run {

/// {ended, message, dem_bursts, pbm_bursts, dem_s, pbm_s, estimation_s, wall_s, core_use, bursts: [{kind, number,
/// reason, process_time_s, wall_s, d50_m, particles}], results, report}. `results_h5` and `report` may be empty.
json::Value summary_json(const CampaignResults& results, const std::filesystem::path& results_h5,
                         const std::filesystem::path& report);

/// The same as text, a line a burst.
std::string summary_text(const CampaignResults& results, const std::filesystem::path& results_h5,
                         const std::filesystem::path& report);

/// Who ran when on which cores, a line a task, and the core use: what a dry run prints.
std::string timeline_text(const std::vector<pilot::Interval>& timeline, const pilot::Usage& usage);
json::Value timeline_json(const std::vector<pilot::Interval>& timeline);

}  // namespace granary::run
