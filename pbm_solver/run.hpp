// granary-pbm run: one case from its file to out.h5, progress.jsonl and checkpoint.h5.
#pragma once

#include <filesystem>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pbm_solver/parallel/communicator.hpp"

namespace granary::pbm {

struct RunOptions {
  std::filesystem::path case_file;
  std::filesystem::path out;  ///< progress.jsonl and checkpoint.h5 are written beside it
  int threads = 1;            ///< of each rank
};

/// Runs to the end, or until SIGTERM or SIGUSR1 asked for a stop (see install_stop_signals), and says what it did:
/// {"ended": "done" | "stopped", "time_s", "wall_s", "cpu_s", "steps", ...}. Collective over the ranks.
/// Errors: bad input (2); the tolerance cannot be kept (20); a full disk.
Result<json::Value> run_case(const RunOptions& options, const Communicator& ranks);

/// From now on SIGTERM and SIGUSR1 end a run after its current step, with a checkpoint.
void install_stop_signals();

}  // namespace granary::pbm
