// What a campaign leaves behind at its end: results.h5 and report.html.
#pragma once

#include "common/result.hpp"
#include "common/results/campaign_results.hpp"
#include "controller/commands/session.hpp"
#include "controller/coupling/state.hpp"
#include "controller/run/file_handover.hpp"

namespace granary::commands {

/// Results and report of all bursts that are over, whatever the campaign's end; and of its estimation.
Result<CampaignResults> finish(Session& session, const run::FileHandover& handover, const coupling::State& state);

}  // namespace granary::commands
