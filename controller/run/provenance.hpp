// Versions, seeds and the machine of a campaign, for its results.
#pragma once

#include <filesystem>

#include "common/results/campaign_results.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/coupling/state.hpp"

namespace granary::run {

/// Everything but started and finished.
Result<Provenance> provenance_of(const campaign::Campaign& campaign, const std::filesystem::path& dir,
                                 const coupling::State& state);

/// [s] since 1970 as ISO 8601, UTC: "2026-11-22T03:00:00Z".
std::string iso_time(double wall_time);

}  // namespace granary::run
