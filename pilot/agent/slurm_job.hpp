// The job of Slurm that we are in, in Slurm's own words: its nodes, cores, memory and end.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "pilot/schedule/machine.hpp"

namespace granary::pilot {

struct SlurmJob {
  std::string id;
  Machine machine;                 ///< nodes by Slurm's names; cores as many as the job has there, numbered 0, 1, ...
  std::string address;             ///< of the node we are on, as Slurm calls it
  std::optional<double> end_time;  ///< [s since 1970-01-01 UTC]; none: unlimited
};

/// Asks scontrol about the job that the environment names. Errors: we are in none; no scontrol; words we do not know.
Result<SlurmJob> current_slurm_job();

// What follows is pure, for tests.

/// One group of equal nodes in "scontrol -o -d show job": Nodes=node[1-2] CPU_IDs=0-3,8 Mem=4096 ...
struct NodeGroup {
  std::string nodes;  ///< still folded: node[1-2]
  int cpus = 0;
  std::int64_t memory_mb = 0;  ///< 0: not counted by Slurm
};
std::vector<NodeGroup> node_groups(const std::string& job_words);
/// How many numbers "0-3,8" names; 0 if it is no such list.
int count_ids(const std::string& ids);
/// The value of KEY=value in a line of words; "" if it is not there.
std::string word(const std::string& line, const std::string& key);
/// Slurm's "2026-11-22T09:25:22", this machine's local time. Nothing for "Unknown" and the like.
std::optional<double> wall_time_of(const std::string& text);

}  // namespace granary::pilot
