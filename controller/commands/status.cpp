#include "controller/commands/status.hpp"

#include "controller/commands/past.hpp"
#include "controller/commands/slurm_queue.hpp"
#include "pilot/control/control.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

namespace {

Result<json::Value> past_status(const fs::path& dir) {
  if (fs::exists(dir / "campaign.json") && !fs::exists(dir / "journal.jsonl"))
    return json::Value::object({{"counts", json::Value::object()}});  // submitted, and not begun
  GRANARY_TRY(const auto past, past_of(dir));
  json::Value status = past->pilot->status();
  if (past->campaign.kind == campaign::Kind::coupled && past->journal.records(kEstimateBegan).empty())
    status.set("coupling", coupling::to_json(past->coupling));
  return status;
}

}  // namespace

Result<json::Value> campaign_status(const fs::path& dir) {
  const bool alive = pilot::pilot_is_alive(dir);
  if (alive) {
    if (auto status = pilot::ask_pilot(dir, json::Value::object({{"ask", "status"}})))
      return status->set("alive", true);
  }
  // A pilot that is just starting, or ending, does not answer: what it does is in the journal.
  GRANARY_TRY(json::Value status, past_status(dir));
  status.set("alive", alive && pilot::pilot_is_alive(dir));
  return status;
}

json::Value queue_status(const fs::path& dir) {
  json::Value jobs = json::Value::array();
  for (const QueuedJob& job : queued_jobs(dir))
    jobs.push(json::Value::object({{"job", job.id}, {"state", job.state}, {"reason", job.reason}}));
  return jobs;
}

}  // namespace granary::commands
