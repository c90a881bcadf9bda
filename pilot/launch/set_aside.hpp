// Keeps what an earlier attempt of a task wrote before the next one starts.
#pragma once

#include <filesystem>

#include "common/result.hpp"
#include "pilot/launch/launcher.hpp"

namespace granary::pilot {

/// The task's output files, absolute, with the defaults filled in. They may be the same file.
std::filesystem::path stdout_path(const Launch& launch);
std::filesystem::path stderr_path(const Launch& launch);

/// Moves them, what the attempt should produce and, in a folder of its own, whatever was written there after the
/// attempt started, into DIR/NAME.attempt-N/.
Status set_aside_attempt(const Launch& earlier, bool own_folder);

}  // namespace granary::pilot
