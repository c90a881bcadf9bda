// A watcher of a run directory that asks as `granary status` does.
#pragma once

#include <filesystem>

#include "common/result.hpp"
#include "controller/watch/watcher.hpp"

namespace granary::commands {

/// Waits a moment for a campaign that is just being started. Error: there is none in `dir`.
Result<watch::Watcher> watcher_of(const std::filesystem::path& dir);

}  // namespace granary::commands
