// A campaign's jobs in Slurm's queue: the script, submitting it, what became of it. DIR/jobs.jsonl keeps their numbers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "controller/campaign/campaign.hpp"

namespace granary::commands {

/// The script of a job that goes on with the campaign in `dir`. The shell reads nothing in it but two quoted paths.
std::string batch_script(const campaign::Campaign& campaign, const std::filesystem::path& program,
                         const std::filesystem::path& dir);

/// Writes DIR/job.sh and gives it to sbatch; the job's number. `chained`: it starts when the job we are in has ended.
/// Errors: what sbatch says.
Result<std::string> submit_job(const campaign::Campaign& campaign, const std::filesystem::path& dir, bool chained);

/// Jobs that followed by themselves on the last one a user submitted.
int n_chained_jobs(const std::filesystem::path& dir);

struct QueuedJob {
  std::string id, state, reason;  ///< Slurm's words: PENDING, RUNNING; Priority, Resources
};
/// The campaign's jobs that Slurm still knows and that have not ended.
std::vector<QueuedJob> queued_jobs(const std::filesystem::path& dir);
/// Takes a job out of the queue.
Status cancel_job(const std::string& id);

}  // namespace granary::commands
