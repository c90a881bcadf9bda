// A campaign whose pilot is not alive, as its journal tells it. Nothing is started or written.
#pragma once

#include <filesystem>
#include <memory>

#include "controller/campaign/campaign.hpp"
#include "controller/coupling/state.hpp"
#include "pilot/journal/journal.hpp"
#include "pilot/launch/simulated_launcher.hpp"
#include "pilot/loop/virtual_loop.hpp"
#include "pilot/pilot.hpp"

namespace granary::commands {

/// Journalled by `granary estimate`: its campaign couples nothing.
inline constexpr const char* kEstimateBegan = "estimate.began";

/// The same pilot on a copy of the journal in memory, at the moment the campaign would go on.
struct Past {
  pilot::VirtualLoop loop;
  pilot::Journal journal = pilot::Journal::in_memory();
  pilot::SimulatedLauncher launcher{loop, [](const pilot::TaskSpec&) { return pilot::SimulatedRun{}; }};
  std::unique_ptr<pilot::Pilot> pilot;
  campaign::Campaign campaign;
  coupling::State coupling;
};

/// Errors: no journal there; a damaged one; a campaign.json that this version understands otherwise.
Result<std::unique_ptr<Past>> past_of(const std::filesystem::path& dir);

}  // namespace granary::commands
