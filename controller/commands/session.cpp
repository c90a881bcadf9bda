#include "controller/commands/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <utility>

#include "common/log.hpp"
#include "controller/commands/slurm_queue.hpp"

namespace granary::commands {
namespace fs = std::filesystem;
using campaign::Campaign;

namespace {

/// The cores: of this machine, of virtual nodes on it, or of a job of Slurm.
Status take_cores(Session& session, const SessionOptions& options) {
  const campaign::Resources& resources = session.campaign.resources;
  const int cores = options.cores > 0 ? options.cores : resources.cores.value_or(0);
  if (options.virtual_nodes > 0) {
    GRANARY_TRY(const pilot::Machine here, pilot::local_machine());
    GRANARY_TRY(session.block, pilot::NodeBlock::of_virtual_nodes(session.loop, session.dir, options.virtual_nodes,
                                                                  cores > 0 ? cores : here.n_cores()));
  } else if (resources.backend == campaign::Resources::Backend::slurm) {
    GRANARY_TRY(session.block, pilot::NodeBlock::of_slurm_job(session.loop, session.dir, cores));
  } else {
    GRANARY_TRY(session.machine, pilot::local_machine(cores));
    session.local = std::make_unique<pilot::LocalLauncher>(session.loop, session.machine);
  }
  if (session.block) session.machine = session.block->machine();
  return campaign::check_resources(session.campaign, static_cast<int>(session.machine.nodes.size()),
                                   session.machine.largest_node());
}

void join_block(Session& session) {
  pilot::Pilot* pilot = session.pilot.get();
  session.block->watch([pilot](int node, const std::string& reason) { pilot->lose_node(node, reason); },
                       [pilot](int node) { pilot->regain_node(node); });
  if (const auto end = session.block->end_time()) pilot->deadline(*end - session.campaign.resources.stop_before);
}

}  // namespace

Result<std::unique_ptr<Session>> open_session(const fs::path& dir, Campaign campaign, const SessionOptions& options) {
  GRANARY_TRY(pilot::RunLock lock, pilot::RunLock::take(dir));
  GRANARY_TRY(pilot::Journal journal, pilot::Journal::open(dir / "journal.jsonl"));
  if (journal.dropped_bytes() > 0)
    log::warning("journal", fmt::format("{} bytes of a torn last record were dropped", journal.dropped_bytes()));
  auto session = std::make_unique<Session>(dir, std::move(campaign), std::move(lock), std::move(journal));
  GRANARY_CHECK(take_cores(*session, options));
  pilot::Launcher& launcher =
      session->block ? static_cast<pilot::Launcher&>(session->block->launcher()) : *session->local;
  GRANARY_TRY(session->pilot, pilot::Pilot::open({dir, session->machine}, session->loop, launcher, session->journal));
  if (session->block) join_block(*session);
  return session;
}

Status Session::serve(pilot::ControlServer::Answer answer) {
  const auto noting_stops = [this, answer = std::move(answer)](const json::Value& request) {
    if (request.text_or("ask", "") == "stop" && request.text_or("task", "").empty()) stopped_by_user = true;
    return answer(request);
  };
  if (block) block->launcher().answer(noting_stops);
  GRANARY_TRY(control, pilot::ControlServer::listen(loop, dir, noting_stops));
  return {};
}

void Session::stop_on_signals(std::function<void(const std::string&)> ask_stop) {
  loop.on_signals({SIGINT, SIGTERM, SIGHUP}, [this, ask_stop](int signal) {
    if (std::exchange(stopped_by_user, true)) return loop.stop();
    ask_stop(signal == SIGINT ? "interrupted by the user" : fmt::format("signal {}", signal));
  });
  if (campaign.resources.backend != campaign::Resources::Backend::slurm) return;
  loop.on_signals({SIGUSR1}, [this, ask_stop](int) {
    log::info("pilot", "the job's time is nearly over: everything is stopped");
    submit_next_job();  // now: nobody knows whether the stop will end in time
    ask_stop("the job's time is nearly over");
  });
}

void Session::submit_next_job() {
  if (campaign.resources.chain == 0 || stopped_by_user || std::exchange(next_job_submitted, true)) return;
  if (n_chained_jobs(dir) >= campaign.resources.chain)
    return log::warning("pilot",
                        fmt::format("the chain of {} further job(s) is at its end; go on with: granary submit {}",
                                    campaign.resources.chain, dir.string()));
  const auto job = submit_job(campaign, dir, true);
  if (job) return log::info("pilot", fmt::format("job {} will go on", *job));
  log::error("pilot", job.error().message);
}

}  // namespace granary::commands
