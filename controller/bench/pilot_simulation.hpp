// The pilot at a scale no test machine has: the real scheduler, journal and life cycle on a virtual clock.
#pragma once

#include <cstdint>
#include <filesystem>

#include "common/result.hpp"

namespace granary::bench {

struct SimulationSize {
  int nodes = 0, cores = 0;  ///< nodes; cores of each
  int tasks = 0;
};

/// What one simulated campaign cost, and how well it filled the machine.
struct SimulationRun {
  SimulationSize size;
  int finished = 0;
  double submit_s = 0.0, run_s = 0.0;  ///< real time: queueing all tasks; then placing and ending them
  double cpu_s = 0.0;                  ///< of both, this process [s]
  double bytes_per_task = 0.0;         ///< growth of resident memory at its largest
  double journal_bytes = 0.0;
  double makespan = 0.0;     ///< virtual [s]
  double lower_bound = 0.0;  ///< no schedule ends earlier: all core seconds on all cores, or the longest chain [s]
  double core_use = 0.0;     ///< busy core seconds of makespan x cores
  double placements_per_s() const { return static_cast<double>(finished) / (submit_s + run_s); }
  double cost_per_task() const { return cpu_s / static_cast<double>(finished); }  ///< [s of CPU]
};

/// A mixed load, the same for the same size: 70 % single cores, 30 % MPI with 2 to 4096 ranks (log-uniform), 0.1 s to 1
/// h (log-uniform), most with an expected time of up to twice the true one, some with memory, priority or a
/// predecessor. The journal is written to a file in `dir`, which is removed. Error: the journal cannot be written.
Result<SimulationRun> simulate_pilot(const SimulationSize& size, const std::filesystem::path& dir);

/// Likewise; what takes milliseconds is run several times, and the one in the middle by its CPU time counts.
Result<SimulationRun> simulate_pilot_steadily(const SimulationSize& size, const std::filesystem::path& dir);

/// "nodes=100,cores=64,tasks=1000". Error: anything else.
Result<SimulationSize> parse_simulation_size(const std::string& text);

}  // namespace granary::bench
