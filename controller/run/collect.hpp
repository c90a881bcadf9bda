// What a campaign left on disk -> CampaignResults: the one place where bursts become series.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/results/campaign_results.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/coupling/state.hpp"
#include "controller/run/file_handover.hpp"
#include "pilot/journal/journal.hpp"
#include "pilot/pilot.hpp"

namespace granary::run {

/// What only the pilot and the runner know.
struct RunRecord {
  coupling::State state;
  std::vector<pilot::TaskEnd> ends;
  std::vector<pilot::Interval> timeline;
  std::vector<pilot::Record> estimation;  ///< what the journal has of it
  int cores = 1;
  double wall = 0.0;              ///< pilot time the campaign took [s]
  std::string started, finished;  ///< ISO 8601, UTC
};

/// Reads every burst that is over. A burst whose files are damaged is an error that names the file: results are whole
/// or not at all.
Result<CampaignResults> collect(const campaign::Campaign& campaign, const FileHandover& handover,
                                const std::filesystem::path& dir, const RunRecord& record);

}  // namespace granary::run
