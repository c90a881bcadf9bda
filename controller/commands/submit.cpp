#include <fmt/format.h>

#include <cstdio>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/commands/commands.hpp"
#include "controller/commands/slurm_queue.hpp"
#include "pilot/control/control.hpp"

namespace granary::commands {
namespace fs = std::filesystem;
using campaign::Campaign;

namespace {

void say_submitted(const fs::path& dir, const std::string& job) {
  fmt::print("job {} -> {}\n", job, dir.string());
  fmt::print(stderr, "see it with: granary status {0}; end it with: granary stop {0}\n", dir.string());
}

/// A campaign that was stopped, or whose job ended before it.
Result<Exit> submit_again(const fs::path& dir, bool dry_run) {
  GRANARY_TRY(const Campaign campaign, campaign::read_written_campaign(dir / "campaign.json"));
  if (campaign.resources.backend != campaign::Resources::Backend::slurm)
    return Error{
        fmt::format("{}: this campaign runs on one machine (/resources/backend is \"local\"): granary resume {}",
                    dir.string(), dir.string())};
  if (dry_run) {
    fmt::print("{}", batch_script(campaign, program_folder() / "granary", dir));
    return Exit::ok;
  }
  if (pilot::pilot_is_alive(dir)) return Error{fmt::format("{}: a pilot is running on this folder.", dir.string())};
  for (const QueuedJob& job : queued_jobs(dir))
    return Error{fmt::format("{}: job {} is in the queue already ({}).", dir.string(), job.id, job.state)};
  GRANARY_TRY(const std::string job, submit_job(campaign, dir, false));
  say_submitted(dir, job);
  return Exit::ok;
}

}  // namespace

Result<Exit> submit(const RunOptions& options) {
  const fs::path given = fs::absolute(options.workflow).lexically_normal();
  if (fs::is_directory(given)) return submit_again(given, options.dry_run);
  std::vector<std::string> overrides = options.overrides;
  overrides.emplace_back("/resources/backend=\"slurm\"");
  GRANARY_TRY(const Campaign campaign, campaign::read_campaign(options.workflow, overrides));
  const fs::path dir = run_folder(options.dir, campaign.name);
  if (options.dry_run) {
    fmt::print("{}", batch_script(campaign, program_folder() / "granary", dir));
    return Exit::ok;
  }
  if (fs::exists(dir / "campaign.json"))
    return Error{
        fmt::format("{}: a campaign is there already. Go on with it: granary submit {}; or choose another --dir.",
                    dir.string(), dir.string())};
  GRANARY_CHECK(make_folders(dir));
  GRANARY_CHECK(json::write_file(dir / "campaign.json", campaign::to_json(campaign)));
  GRANARY_TRY(const std::string job, submit_job(campaign, dir, false));
  say_submitted(dir, job);
  return Exit::ok;
}

}  // namespace granary::commands
