// Single-node tasks inside a job of Slurm: through agents, and as steps that srun starts. In one run, so that the load
// of the machine is the same for both.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::bench {

struct SlurmBench {
  std::filesystem::path dir;  ///< an empty folder that all nodes of the job see
  int in_flight = 8;          ///< at once, spread over the job's nodes
  int tasks = 4000;           ///< of /bin/true through agents, output captured, journal on
  int steps = 160;            ///< of /bin/true through srun
};

/// Whether we are in a job of Slurm.
bool in_slurm_job();

/// {agent_per_s, srun_per_s, ratio, nodes, in_flight, start_s (from srun to the first task done)}.
/// Errors: no job, no agents, a task that failed.
Result<json::Value> run_slurm_pilot_bench(const SlurmBench& bench, const std::function<void(const std::string&)>& say);

}  // namespace granary::bench
