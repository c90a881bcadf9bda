// What can be known of a campaign from outside: `granary status`, `watch` and `serve` show the same.
#pragma once

#include <filesystem>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::commands {

/// The living pilot's answer (Pilot::status(), with "coupling" of a coupled campaign), or the same from the journal
/// where none is alive, or it does not answer; and "alive".
/// Errors: no campaign in `dir`; the journal cannot be read.
Result<json::Value> campaign_status(const std::filesystem::path& dir);

/// [{job, state, reason}]: the campaign's jobs in Slurm's queue. Asks Slurm: not every second.
json::Value queue_status(const std::filesystem::path& dir);

}  // namespace granary::commands
