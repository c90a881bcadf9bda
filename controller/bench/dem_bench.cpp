#include "controller/bench/dem_bench.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <optional>

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

constexpr std::uintmax_t kMega = 1'000'000, kRoom = 100 * kMega;  // [bytes]
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

/// Below TMPDIR, with room for the states of all cases.
Result<ScratchFolder> roomy_folder() {
  const char* wanted = std::getenv("TMPDIR");
  const auto refusal = [&](const std::string& why) {
    return Error{
        fmt::format("TMPDIR is {}: {}. Set it to a folder with room for {} MB.",
                    wanted != nullptr ? fmt::format("\"{}\"", wanted) : "not set, so /tmp", why, kRoom / kMega),
        Exit::bad_input};
  };
  std::error_code failed;
  const std::filesystem::path below = std::filesystem::temp_directory_path(failed);
  if (failed) return refusal("there is no such folder");
  const auto space = std::filesystem::space(below, failed);
  if (!failed && space.available < kRoom)
    return refusal(fmt::format("only {} MB are free there", space.available / kMega));
  std::optional<ScratchFolder> folder = ScratchFolder::make(below);
  if (!folder) return refusal("no folder can be made there");
  return std::move(*folder);
}

}  // namespace

Result<Value> run_dem_bench(Effort effort, const std::vector<std::string>& parts, const Say& say) {
  GRANARY_CHECK(check(parts));
  GRANARY_TRY(const pilot::Machine machine, pilot::local_machine());
  GRANARY_TRY(const ScratchFolder folder, roomy_folder());
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
    GRANARY_TRY(const Value rows, speed_rows(effort, folder.path(), in_turn));
    document.set("speed", rows);
  }
  if (wanted("overheads")) {
    GRANARY_TRY(const Value all, overheads(effort, folder.path(), in_turn));
    for (const auto& [key, value] : all.members()) document.set(key, value);
  }
  if (wanted("comparison")) {
    GRANARY_TRY(const Value rows, comparison_rows(effort, folder.path(), in_turn));
    document.set("comparison", rows);
  }
  if (wanted("choices")) {
    GRANARY_TRY(const Value rows, choice_rows(effort, folder.path(), in_turn));
    document.set("choices", rows);
  }
  return document.set("load_at_end", load_of_machine());
}

}  // namespace granary::bench
