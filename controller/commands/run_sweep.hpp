// Campaigns of kind sweep: run to the end, and reported from what is in the folder.
#pragma once

#include <filesystem>

#include "common/result.hpp"
#include "controller/commands/session.hpp"

namespace granary::commands {

Result<Exit> run_sweep(Session& session, bool json, bool quiet);

/// Table, results and page from the cases' folders, whether the sweep is over or not. Starts nothing.
Result<Exit> report_sweep(const std::filesystem::path& dir);

}  // namespace granary::commands
