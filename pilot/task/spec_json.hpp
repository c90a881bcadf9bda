// A task as a workflow writes it: reading with all problems at once, writing for the journal and campaign.json.
// Every key: docs/pilot.md.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/json/problems.hpp"
#include "common/json/reader.hpp"
#include "common/json/value.hpp"
#include "pilot/schedule/machine.hpp"
#include "pilot/task/spec.hpp"

namespace granary::pilot {

/// One item of a workflow's "tasks" list. Problems go to the reader's list; what is wrong takes its default.
TaskSpec read_task(json::Reader& task);

/// What only shows in the whole list: names used twice, unknown and circular dependencies, more cores, nodes or memory than the
/// machine has. Pointers are `pointer`/INDEX/KEY; the order of `tasks` is that of the document.
void check_tasks(std::span<const TaskSpec> tasks, const Machine& machine, const std::string& file, json::Problems& problems,
                 const std::string& pointer = "/tasks");

/// SI numbers, defaults left out: {"name": "a", "command": ["x"], "timeout_s": 5}. from_json takes exactly this form.
json::Value to_json(const TaskSpec& spec);
TaskSpec spec_from_json(const json::Value& value);

}  // namespace granary::pilot
