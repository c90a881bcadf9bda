#include "controller/bench/dem_bench.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <mutex>

#include "common/version.hpp"
#include "controller/bench/dem_choices.hpp"
#include "controller/bench/dem_comparison.hpp"
#include "controller/bench/dem_run.hpp"
#include "controller/bench/scratch_folder.hpp"
#include "pilot/launch/command.hpp"
#include "pilot/schedule/machine.hpp"

namespace granary::bench {
namespace {

using json::Value;

constexpr const char* kParts[] = {"speed", "overheads", "comparison", "choices"};

Status check(const std::vector<std::string>& parts) {
  for (const std::string& part : parts)
    if (std::find(std::begin(kParts), std::end(kParts), part) == std::end(kParts))
      return Error{fmt::format("--only {}: there is no such part. Write one of {}.", part, fmt::join(kParts, ", ")),
                   Exit::bad_input};
  const char* path = std::getenv("PATH");
  if (!pilot::find_executable("liggghts", "", path != nullptr ? path : ""))
    return Error{
        "There is no stock LIGGGHTS to compare with: liggghts is not in the PATH (Debian: apt-get install "
        "liggghts).",
        Exit::bad_input};
  return {};
}

}  // namespace

Result<Value> run_dem_bench(Effort effort, const std::vector<std::string>& parts, const Say& say) {
  GRANARY_CHECK(check(parts));
  GRANARY_TRY(const pilot::Machine machine, pilot::local_machine());
  std::error_code failed;
  const std::filesystem::path below = std::filesystem::temp_directory_path(failed);
  const auto folder = failed ? std::nullopt : ScratchFolder::make(below);
  if (!folder)
    return Error{fmt::format("{}: no folder can be made here. Set TMPDIR to one where some 100 MB can be written.",
                             below.empty() ? "TMPDIR" : below.string()),
                 Exit::task_failed};
  std::mutex one_at_a_time;
  const Say in_turn = [&](const std::string& what) {
    const std::scoped_lock lock(one_at_a_time);
    say(what);
  };
  const auto wanted = [&](const char* part) {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  Value document = Value::object({{"bench", "dem"},
                                  {"version", std::string(version())},
                                  {"revision", std::string(revision())},
                                  {"effort", std::string(name_of(effort))},
                                  {"cores", machine.n_cores()},
                                  {"load_at_start", load_of_machine()},
                                  {"stock",
                                   "speed: the program liggghts of Debian; comparison and differences: "
                                   "granary-dem with fix mesh/surface, move/mesh and wall/gran"}});
  if (wanted("speed")) {
    GRANARY_TRY(const Value rows, speed_rows(effort, folder->path(), in_turn));
    document.set("speed", rows);
  }
  if (wanted("overheads")) {
    GRANARY_TRY(const Value all, overheads(effort, folder->path(), in_turn));
    for (const auto& [key, value] : all.members()) document.set(key, value);
  }
  if (wanted("comparison")) {
    GRANARY_TRY(const Value rows, comparison_rows(effort, folder->path(), in_turn));
    document.set("comparison", rows);
  }
  if (wanted("choices")) {
    GRANARY_TRY(const Value rows, choice_rows(effort, folder->path(), in_turn));
    document.set("choices", rows);
  }
  return document.set("load_at_end", load_of_machine());
}

}  // namespace granary::bench
