// What the pilot tells of its tasks: pure views of the task table.
#pragma once

#include <vector>

#include "common/json/value.hpp"
#include "pilot/pilot.hpp"
#include "pilot/schedule/resources.hpp"
#include "pilot/task/table.hpp"

namespace granary::pilot {

/// Of a task that has ended; `dir` is its absolute folder.
TaskEnd end_of(const Task& task, std::filesystem::path dir);
Usage usage_of(const Table& table, int n_cores, double now);
std::vector<Interval> timeline_of(const Table& table, double now);
json::Value status_of(const Table& table, const Resources& resources, double now);

}  // namespace granary::pilot
