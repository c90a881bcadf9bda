#include <fmt/format.h>

#include "common/json/io.hpp"
#include "controller/commands/commands.hpp"
#include "pilot/control/control.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

namespace {

/// A file holds one task, a list of them, or a workflow's {"tasks": [...]}.
json::Array tasks_in(const json::Value& document) {
  if (document.is_array()) return document.items();
  const json::Value& tasks = document["tasks"];
  return tasks.is_array() ? tasks.items() : json::Array{document};
}

}  // namespace

Result<Exit> submit_tasks(const fs::path& dir, const fs::path& file) {
  GRANARY_TRY(const json::Value document, json::read_file(file));
  std::string problems;
  int submitted = 0;
  for (const json::Value& task : tasks_in(document)) {
    const auto answer = pilot::ask_pilot(dir, json::Value::object({{"ask", "submit"}, {"task", task}}));
    if (answer) {
      fmt::print("{}\n", answer->text_or("submitted", ""));
      ++submitted;
    } else {
      problems += fmt::format("{}{}: {}", problems.empty() ? "" : "\n", file.string(), answer.error().message);
    }
  }
  if (problems.empty()) return Exit::ok;
  return Error{fmt::format("{}\n{} task(s) were submitted, the others were not.", problems, submitted)};
}

}  // namespace granary::commands
