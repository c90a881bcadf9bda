// Decides which ready tasks start on which cores, and which fillers give way or go on. Pure: no clock, no processes, no
// files. The rules, and why nothing starves: docs/pilot.md#scheduling.
#pragma once

#include <limits>
#include <variant>
#include <vector>

#include "pilot/schedule/resources.hpp"
#include "pilot/task/table.hpp"

namespace granary::pilot {

struct StartTask {
  TaskId id;
  std::vector<int> cores;
};
struct SuspendFiller {
  TaskId id;
};
struct KillFiller {
  TaskId id;
};  ///< its cores are free only when it has ended
struct ResumeFiller {
  TaskId id;
  std::vector<int> cores;
};
using Decision = std::variant<StartTask, SuspendFiller, KillFiller, ResumeFiller>;

/// What to do now, in this order. Done by the caller, each decision finds its cores free. Empty: nothing to do.
///  - Ready tasks go by priority, then by order of submission. One that cannot start reserves the cores it waits for:
///  later ones
///    use only what is left over, so small tasks never keep a large one waiting for ever.
///  - Cores of fillers count as free for ready tasks; the fillers on them give way at once.
///  - Fillers get what is idle after that, reserved cores too.
///  - What cannot end in `time_left` [s] is not started unless it can be stopped and resumed.
std::vector<Decision> schedule(const Table& table, const Resources& resources,
                               double time_left = std::numeric_limits<double>::infinity());

}  // namespace granary::pilot
