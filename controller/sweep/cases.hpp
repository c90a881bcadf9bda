// The cases of a sweep as tasks of the pilot, each with its folder and the files its program starts from.
// What came of them: outcome.hpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "controller/campaign/campaign.hpp"
#include "pilot/pilot.hpp"

namespace granary::sweep {

/// "cases/0001", relative to the run's folder.
std::filesystem::path folder_of(const campaign::SweepCase& one);
/// "case-0001": of its task.
std::string task_name(const campaign::SweepCase& one);

/// One task a case; `programs` is where granary-dem and granary-pbm are.
std::vector<pilot::TaskSpec> tasks_of(const campaign::Campaign& campaign, const std::filesystem::path& programs);

/// Names of cases that were cut in the middle.
struct CutCases {
  std::vector<std::string> anew;      ///< start anew: their folder was set aside (cases/0001.cut1)
  std::vector<std::string> going_on;  ///< go on from the last state that was written
};

/// Writes what each case that is not over starts from. A DEM that left a state (restart.liggghts) goes on from it; any
/// other case that was cut starts anew. Errors: a full disk; what the writers of the cases refuse.
Result<CutCases> prepare_cases(const campaign::Campaign& campaign, const std::filesystem::path& dir,
                               const pilot::Pilot& pilot);

}  // namespace granary::sweep
