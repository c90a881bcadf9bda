// Stands beside a node's worker and does nothing else: beats its heart, ends what a dead worker leaves, starts the
// next. It touches no file once it has begun, so that a slow file system cannot make a living node look dead.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace granary::pilot {

/// Until the pilot is gone or wants no agent here. `node`: what Slurm calls this node. Errors: no endpoint, no secret.
Status run_guardian(const std::filesystem::path& dir, const std::string& node);

}  // namespace granary::pilot
