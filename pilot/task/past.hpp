// A task with all that has happened to it, as one record: what a compacted journal holds instead of its events.
#pragma once

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pilot/task/table.hpp"

namespace granary::pilot {

/// Of a task that does not run. Its dependents are not in it: they name it themselves.
json::Value past_to_json(const Task& task);
/// Error: not what past_to_json() writes.
Result<Task> past_from_json(const json::Value& value);

}  // namespace granary::pilot
