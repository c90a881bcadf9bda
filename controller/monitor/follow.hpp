// Waits for lines: inotify on the growing file (or on its folder until the file is there), signals as a descriptor, the
// end of a process as a descriptor. Sleeps in between; a look every second serves file systems that send no notices.
#pragma once

#include <filesystem>
#include <optional>

#include "common/result.hpp"
#include "controller/monitor/watched.hpp"

namespace granary::monitor {

struct FollowSettings {
  Program program = Program::dem;
  std::filesystem::path folder;  ///< the burst's
  Options options;
  std::optional<int> pid;   ///< of the watched program, if on this machine: its end is the end
  bool finished = false;    ///< nothing will be written any more: judge what is there
  double look_every = 1.0;  ///< without any notice [s]
};

/// Follows the burst until there is a verdict, SIGTERM or SIGINT arrives, or the program ends; then what is in the file
/// is read to its end, so the verdict does not depend on who was faster. Blocks SIGTERM and SIGINT for this process.
/// Errors: no such folder; a bad or torn line (file, line number, what to do); the kernel refuses a descriptor.
Result<Verdict> follow(const FollowSettings& settings);

}  // namespace granary::monitor
