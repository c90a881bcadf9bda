// All processes of an attempt, wherever they went: ranks in process groups of their own, daemons, orphans. They are
// known by the mark in their environment, which children inherit.
#pragma once

#include <string>
#include <vector>

namespace granary::pilot {

inline constexpr const char* kMarkVariable = "GRANARY_MARK";

/// Pids of the living processes (zombies don't count) of this user that carry the mark. Reads /proc once: about 1 ms.
std::vector<int> marked_processes(const std::string& mark);
void signal_marked(const std::string& mark, int signal);
/// Pins every thread of every process of the attempt.
void pin_marked(const std::string& mark, const std::vector<int>& cpus);

}  // namespace granary::pilot
