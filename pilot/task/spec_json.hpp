// A task as a workflow writes it: reading with all problems at once, writing for the journal and campaign.json.
// What only shows in a whole list of tasks is schedule/check_tasks. Every key: docs/pilot.md.
#pragma once

#include "common/json/reader.hpp"
#include "common/json/value.hpp"
#include "pilot/task/spec.hpp"

namespace granary::pilot {

/// One item of a workflow's "tasks" list. Problems go to the reader's list; what is wrong takes its default.
TaskSpec read_task(json::Reader& task);

/// SI numbers, defaults left out: {"name": "a", "command": ["x"], "timeout_s": 5}. from_json takes exactly this form.
json::Value to_json(const TaskSpec& spec);
/// Appends the text of the same.
void append(std::string& text, const TaskSpec& spec);
TaskSpec spec_from_json(const json::Value& value);

}  // namespace granary::pilot
