// Campaigns of kind sweep: run to the end, and reported from what is in the folder.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"
#include "controller/commands/session.hpp"

namespace granary::commands {

Result<Exit> run_sweep(Session& session, bool json, bool quiet);

/// Table, results and page from the cases' folders, whether the sweep is over or not. Starts nothing.
/// `figures`: also every figure as FIGURES/PREFIXname.svg; empty: not.
Result<Exit> report_sweep(const std::filesystem::path& dir, const std::filesystem::path& figures,
                          const std::string& prefix);

}  // namespace granary::commands
