#include "controller/sweep/cases.hpp"

#include <fmt/format.h>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "dem_templates/render/deck.hpp"

namespace granary::sweep {
namespace {

namespace fs = std::filesystem;
using campaign::Campaign;
using campaign::Sweep;
using campaign::SweepCase;

constexpr const char* kState = "restart.liggghts";

pilot::TaskSpec dem_task(const Campaign& one, const fs::path& programs) {
  pilot::TaskSpec task;
  task.command = {(programs / "granary-dem").string(), "-in", "in.liggghts", "-log", "log.liggghts", "-screen", "none"};
  task.ranks = one.dem_case.ranks;
  task.resumable = true;
  task.produces = {kState, "tallies.jsonl", "fragments.jsonl"};
  return task;
}

pilot::TaskSpec pbm_task(const Campaign& one, const fs::path& programs) {
  pilot::TaskSpec task;
  task.command = {(programs / "granary-pbm").string(), "run", "case.json", "--out", "out.h5", "--threads",
                  std::to_string(one.pbm.threads)};
  task.ranks = one.pbm.ranks;
  task.threads = one.pbm.threads;
  task.produces = {"out.h5", "progress.jsonl"};
  return task;
}

Status write_case(const Sweep& sweep, const SweepCase& one, const fs::path& folder, bool goes_on) {
  if (sweep.solver == Sweep::Solver::dem) {
    dem::DemCase dem = one.understood->dem_case;
    if (goes_on) dem.restart = kState;
    return dem::write_burst(dem, folder);
  }
  GRANARY_CHECK(make_folders(folder));
  return json::write_file(folder / "case.json", pbm::to_json(one.understood->pbm_case));
}

bool is_over(const pilot::Pilot& pilot, const SweepCase& one) {
  const auto id = pilot.find(task_name(one));
  if (!id) return false;
  const auto state = pilot.state(*id);
  return state == pilot::TaskState::finished || state == pilot::TaskState::failed;
}

/// Whether its program has been started in it: what it printed is there.
bool was_begun(const SweepCase& one, const fs::path& folder) { return fs::exists(folder / (task_name(one) + ".out")); }

Status set_aside(const fs::path& folder) {
  std::error_code code;
  int n = 1;
  while (fs::exists(fmt::format("{}.cut{}", folder.string(), n))) ++n;
  fs::rename(folder, fmt::format("{}.cut{}", folder.string(), n), code);
  if (code)
    return Error{fmt::format("{}: cannot be set aside: {}.", folder.string(), code.message()), Exit::task_failed};
  return {};
}

}  // namespace

fs::path folder_of(const SweepCase& one) { return fs::path("cases") / one.name; }

std::string task_name(const SweepCase& one) { return "case-" + one.name; }

std::vector<pilot::TaskSpec> tasks_of(const Campaign& campaign, const fs::path& programs) {
  std::vector<pilot::TaskSpec> tasks;
  for (const SweepCase& one : campaign.sweep.cases) {
    pilot::TaskSpec task = campaign.sweep.solver == Sweep::Solver::dem ? dem_task(*one.understood, programs)
                                                                       : pbm_task(*one.understood, programs);
    task.name = task_name(one);
    task.dir = folder_of(one);
    task.stop.grace = 30.0;
    tasks.push_back(std::move(task));
  }
  return tasks;
}

Result<CutCases> prepare_cases(const Campaign& campaign, const fs::path& dir, const pilot::Pilot& pilot) {
  CutCases cut;
  for (const SweepCase& one : campaign.sweep.cases) {
    if (is_over(pilot, one)) continue;
    const fs::path folder = dir / folder_of(one);
    const bool goes_on = fs::exists(folder / kState);
    if (goes_on) {
      cut.going_on.push_back(one.name);
    } else if (was_begun(one, folder)) {
      GRANARY_CHECK(set_aside(folder));
      cut.anew.push_back(one.name);
    }
    GRANARY_CHECK(write_case(campaign.sweep, one, folder, goes_on));
  }
  return cut;
}

}  // namespace granary::sweep
