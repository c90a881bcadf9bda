// What is wrong with a list of tasks as a whole, on a given machine.
#pragma once

#include <span>
#include <string>

#include "common/json/problems.hpp"
#include "common/result.hpp"
#include "pilot/schedule/layout.hpp"
#include "pilot/schedule/machine.hpp"
#include "pilot/task/spec.hpp"

namespace granary::pilot {

/// Names used twice, unknown and circular dependencies, more cores, nodes or memory than the machine has. Pointers are
/// `pointer`/INDEX/KEY; the order of `tasks` is that of the document.
void check_tasks(std::span<const TaskSpec> tasks, const Machine& machine, const std::string& file,
                 json::Problems& problems, const std::string& pointer = "/tasks");

/// Whether the task could start on the empty machine of these layouts; the error's message says what is missing,
/// without the task's name.
Status check_fits(const TaskSpec& spec, const Layouts& layouts);

}  // namespace granary::pilot
