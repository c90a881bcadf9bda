// All processes of an attempt, wherever they went: ranks in process groups of their own, daemons, orphans. They are
// known by the mark in their environment, which children inherit.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace granary::pilot {

inline constexpr const char* kMarkVariable = "GRANARY_MARK";

/// Pids of the living processes (zombies don't count) of this user, other than this one, whose environment has an entry
/// that begins so. Reads /proc once: about 1 ms.
std::vector<int> processes_with(std::string_view entry_begins);
/// Pids of the living processes that carry the mark.
std::vector<int> marked_processes(const std::string& mark);
void signal_marked(const std::string& mark, int signal);
/// Pins every thread of every process of the attempt.
void pin_marked(const std::string& mark, const std::vector<int>& cpus);
/// SIGKILL to all of processes_with(), until there are none (2 s at most). Whether there were any.
bool end_processes_with(std::string_view entry_begins);

}  // namespace granary::pilot
