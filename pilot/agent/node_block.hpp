// The block of nodes a campaign runs on, with an agent on each: those of a job of Slurm, or virtual ones on this
// machine.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "pilot/agent/agent_launcher.hpp"

namespace granary::pilot {

class NodeBlock {
 public:
  /// The nodes of the job we are in; srun starts the agents, each as a step of its own as far as that is cheap. Blocks
  /// until all are there, or the others have come some seconds ago, or for a minute: nodes
  /// whose agent does not come are told as lost by watch(). `cores`: of a node at most; 0: all. Errors: no job, no
  /// srun, not one agent.
  static Result<std::unique_ptr<NodeBlock>> of_slurm_job(RealLoop& loop, const std::filesystem::path& dir,
                                                         int cores = 0);
  /// So many agents on this machine, each for `cores` cores, which they share: to try things out.
  static Result<std::unique_ptr<NodeBlock>> of_virtual_nodes(RealLoop& loop, const std::filesystem::path& dir,
                                                             int nodes, int cores);
  ~NodeBlock();

  AgentLauncher& launcher();
  const Machine& machine() const;
  /// When the job ends [s since 1970-01-01 UTC]; nothing: no limit, or no job.
  std::optional<double> end_time() const;
  /// From here on the pilot is told of nodes that go and come. Agents that went are started anew where that is
  /// possible.
  void watch(std::function<void(int node, const std::string& reason)> lost, std::function<void(int node)> back);

 private:
  struct State;
  explicit NodeBlock(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace granary::pilot
