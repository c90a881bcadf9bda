// What the pilot costs on this machine, with real processes. Each figure's bare limit is measured beside it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::bench {

struct LocalBench {
  std::filesystem::path dir;  ///< an empty folder to work in
  int cores = 0;              ///< 0: all of this machine
  int tasks = 10'000;         ///< of /bin/true
  double seconds = 10.0;      ///< ideal time of each run of sleeping tasks, and of the idle pilot
};

/// {throughput_per_s, spawn_limit_per_s, ratio, submit_to_done_ms, dispatch_ms{p50,p99}, core_use{0.5,0.1,0.01},
/// core_use_static{...}, ..., filler_gives_way_ms{p50,p99}, startup_ms, idle{core_share, resident_mb}, files_per_task,
/// mpi_ms{bare,task}, resume{...}}: docs/pilot.md#figures. What cannot be measured here is null, with `NAME_why`.
/// Errors: the folder cannot be written.
Result<json::Value> run_local_pilot_bench(const LocalBench& bench, const std::function<void(const std::string&)>& say);

}  // namespace granary::bench
