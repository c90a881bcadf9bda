// A live campaign: its folder, its cores and its pilot, whatever the backend.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "controller/campaign/campaign.hpp"
#include "pilot/agent/node_block.hpp"
#include "pilot/control/control.hpp"
#include "pilot/control/run_lock.hpp"
#include "pilot/launch/local_launcher.hpp"
#include "pilot/loop/real_loop.hpp"
#include "pilot/pilot.hpp"

namespace granary::commands {

struct SessionOptions {
  int cores = 0;          ///< of a node; 0: the workflow's, or all of the machine
  int virtual_nodes = 0;  ///< > 0: so many agents on this machine instead of the workflow's backend
};

/// In the order it must be torn down.
struct Session {
  Session(std::filesystem::path run_dir, campaign::Campaign understood, pilot::RunLock held, pilot::Journal opened)
      : dir(std::move(run_dir)), campaign(std::move(understood)), lock(std::move(held)), journal(std::move(opened)) {}

  std::filesystem::path dir;
  campaign::Campaign campaign;
  pilot::RunLock lock;
  pilot::Journal journal;
  pilot::RealLoop loop;
  std::unique_ptr<pilot::NodeBlock> block;      ///< of several nodes
  std::unique_ptr<pilot::LocalLauncher> local;  ///< else
  pilot::Machine machine;
  std::unique_ptr<pilot::Pilot> pilot;
  std::optional<pilot::ControlServer> control;
  bool stopped_by_user = false;
  bool next_job_submitted = false;

  /// Answers on the control socket and, where there are several nodes, over TCP.
  Status serve(pilot::ControlServer::Answer answer);
  /// Calls `ask_stop` with the reason when the user (SIGINT, SIGTERM, SIGHUP; a second one ends the tasks without
  /// grace) or Slurm (SIGUSR1: the walltime is near) wants an end.
  void stop_on_signals(std::function<void(const std::string&)> ask_stop);
  /// After an end that was not the user's: lets the next job of the chain go on, once. Nothing without a chain.
  void submit_next_job();
};

Result<std::unique_ptr<Session>> open_session(const std::filesystem::path& dir, campaign::Campaign campaign,
                                              const SessionOptions& options);

}  // namespace granary::commands
