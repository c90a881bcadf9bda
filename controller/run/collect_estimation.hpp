// What an estimation left on disk and in the journal -> EstimationSummary.
#pragma once

#include <filesystem>
#include <limits>
#include <vector>

#include "common/results/campaign_results.hpp"
#include "controller/campaign/campaign.hpp"
#include "pilot/journal/journal.hpp"

namespace granary::run {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();  ///< a figure that is not there

/// Reads DIR/estimation and DIR/final; what is not there yet stays empty. `journal`: its records of the estimation.
/// Errors: a damaged file is named.
Result<EstimationSummary> estimation_of(const campaign::Campaign& campaign, const std::filesystem::path& dir,
                                        const std::vector<pilot::Record>& journal, const CoreUse& use);

}  // namespace granary::run
