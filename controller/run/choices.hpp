// "What was modelled, what was left out, and what each choice is worth": the page no other tool has. An error or a cost
// that nobody measured says so.
#pragma once

#include <filesystem>
#include <vector>

#include "common/results/campaign_results.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/coupling/state.hpp"

namespace granary::run {

Result<std::vector<ModelChoice>> choices_of(const campaign::Campaign& campaign, const std::filesystem::path& dir,
                                            const coupling::State& state, const CampaignResults& results);

}  // namespace granary::run
