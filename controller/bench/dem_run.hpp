// Runs LIGGGHTS programs in folders of the bench and reads what they print and write.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "dem_templates/case/dem_case.hpp"

namespace granary::bench {

/// One `run` of an input script, from the lines LIGGGHTS prints after it.
struct Loop {
  double seconds = 0.0;       ///< "Loop time of"
  double pair_seconds = 0.0;  ///< "Pair  time"
  long steps = 0, particles = 0;
  double ms_per_step() const { return steps > 0 ? 1e3 * seconds / static_cast<double>(steps) : 0.0; }
};
std::vector<Loop> read_loops(const std::string& printed);

/// A finished program.
struct DemRun {
  std::vector<Loop> loops;
  std::string printed;
  double wall_s = 0.0;  ///< from its start to its end
};

/// `program`: "liggghts" (Debian's) or our granary-dem. `folder` holds in.NAME. One rank: no mpirun; several: each on
/// a core of its own. Errors: it is not there, or ended with an exit code (with the end of what it said).
Result<DemRun> run_dem(const std::string& program, const std::filesystem::path& folder, const std::string& input,
                       int ranks = 1);

/// What runs or wants to run, mean of the last minute; -1 if the system does not say.
double load_of_machine();

/// Our granary-dem beside this program.
std::string granary_dem();

/// A whole burst as a campaign runs it; `more` is added to the end of its input script.
struct Burst {
  DemRun run;
  std::vector<json::Value> tallies;  ///< lines of tallies.jsonl, the header first
};
Result<Burst> run_burst(const dem::DemCase& dem_case, const std::filesystem::path& folder,
                        const std::string& more = "");

/// Calls work(0) ... work(n - 1), as many at once as there are cores, and gives the first error.
/// For what is counted, not timed.
Status at_once(std::size_t n, const std::function<Status(std::size_t)>& work);

}  // namespace granary::bench
