// What the machine itself can do: programs started with posix_spawn and nothing else. The bench's yardstick.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::pilot {

/// Starts `argv` (argv[0] is a path) `count` times, `in_flight` at once, waits for each; seconds for all of them.
/// No pinning, no output files, no record. Error: it cannot be started.
Result<double> bare_spawn_seconds(const std::vector<std::string>& argv, int count, int in_flight);

}  // namespace granary::pilot
