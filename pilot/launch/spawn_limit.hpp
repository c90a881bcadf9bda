// What the machine itself can do: programs started and waited for, and nothing else. The bench's yardsticks.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::pilot {

/// Starts `argv` (argv[0] is a path) `count` times with posix_spawn, `in_flight` at once, waits for each; seconds for
/// all of them. No pinning, no output files, no record. Error: it cannot be started.
Result<double> bare_spawn_seconds(const std::vector<std::string>& argv, int count, int in_flight);

/// Likewise with processes that were made ahead, one at once on each of `cpus`: all that can be done about a start
/// without touching the program.
Result<double> prepared_spawn_seconds(const std::vector<std::string>& argv, int count, const std::vector<int>& cpus);

}  // namespace granary::pilot
