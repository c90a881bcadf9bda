// An estimation without a DEM in a session: begun by `granary estimate`, gone on with by `granary resume`.
#pragma once

#include "common/result.hpp"
#include "controller/commands/session.hpp"

namespace granary::commands {

/// Whether the folder's campaign was begun by `granary estimate`.
bool is_estimate(const Session& session);
Result<Exit> run_estimate(Session& session, bool json, bool quiet);

}  // namespace granary::commands
