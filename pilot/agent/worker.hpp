// One node's agent: starts and ends the tasks the pilot sends it, with the same LocalLauncher as a pilot of one
// machine. It ends all of them, and itself, when it loses the pilot.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace granary::pilot {

struct WorkerOptions {
  std::filesystem::path dir;  ///< the campaign's folder
  std::string node;           ///< what Slurm calls the node
  std::string instance;       ///< of the guardian: tells this agent from another one of the same node
  std::uint16_t port = 0;     ///< the pilot's, in endpoint.json: another port is another pilot's
};

/// How a worker ends, for its guardian.
enum class WorkerEnd : int {
  lost_pilot = 0,  ///< the connection broke: a new worker may find the pilot again
  dismissed = 10,  ///< the pilot wants no agent here (any more)
  no_pilot = 11,   ///< nobody is there
};

/// What the environment of each task of an agent begins with, so that it is found when the agent is gone:
/// GRANARY_AGENT=TAG/NODE/INSTANCE. Each part ends with its '/'.
std::string agent_entry(const std::string& tag, const std::string& node = "", const std::string& instance = "");

/// Until the pilot says so, or is lost. Errors: no endpoint, no secret.
Result<WorkerEnd> run_worker(const WorkerOptions& options);

}  // namespace granary::pilot
