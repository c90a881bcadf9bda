// Why a task waits, or what it did and what it cost, in words. Pure.
#pragma once

#include <string>

#include "pilot/schedule/scheduler.hpp"
#include "pilot/task/table.hpp"

namespace granary::pilot {

/// A few lines. `now`: pilot time [s]. `stopping`: the pilot starts nothing any more.
std::string explain(const Task& task, const Table& table, const Scheduler& scheduler, double now, bool stopping);

}  // namespace granary::pilot
