// Starts tasks on many nodes through their agents: a task goes to the agent of the node its first core is on. Which
// nodes there are, and how agents come to be on them, is node_block's; which agents are there, roster's.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "pilot/launch/launcher.hpp"
#include "pilot/loop/real_loop.hpp"
#include "pilot/schedule/machine.hpp"

namespace granary::pilot {

/// What is to be told when a node goes or comes. Called from the loop.
struct NodeWatcher {
  /// Of what ran there alone `ended` is not called any more; of what ran on other nodes too it is.
  std::function<void(int node, const std::string& reason)> lost = [](int, const std::string&) {};
  std::function<void(int node)> back = [](int) {};
  std::function<void(int node)> missing = [](int) {};  ///< its agent is gone: it may be started anew
};

class AgentLauncher final : public Launcher {
 public:
  /// As Roster::listen().
  static Result<std::unique_ptr<AgentLauncher>> listen(RealLoop& loop, const std::filesystem::path& dir,
                                                       Machine machine, const std::string& address);
  ~AgentLauncher() override;  ///< dismisses the agents: they end what still runs

  /// As Roster::await_all(): until every node has its agent, some have and no other has come for `patience_s`, or the
  /// time is over. The indices of those that have none.
  std::vector<int> await_agents(double timeout_s, double patience_s);
  /// With what the agents found.
  const Machine& machine() const;

  /// From here on nodes that go are told of; those that have no agent yet at once.
  void watch(NodeWatcher watcher);
  /// Answers those who ask from another host.
  void answer(std::function<json::Value(const json::Value& request)> answer);

  Result<ProcessKey> start(const Launch& launch, std::function<void(const RunEnd&)> ended) override;
  void signal(AttemptId attempt, int signal_number) override;
  void kill(AttemptId attempt) override;
  void suspend(AttemptId attempt) override;
  void resume(AttemptId attempt, const CoreSet& cores) override;
  Status set_aside(const Launch& earlier, bool own_folder) override;
  /// Nothing to do: agents end what earlier ones left before they take anything.
  bool end_orphan(const ProcessKey& key, const std::string& mark) override;

 private:
  struct State;
  explicit AgentLauncher(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace granary::pilot
