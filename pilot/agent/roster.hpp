// The agents of a block of nodes: who is there, who is missing, who is lost for good. Which tasks that concerns is
// agent_launcher's.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "pilot/loop/real_loop.hpp"
#include "pilot/schedule/machine.hpp"

namespace granary::pilot {

class Roster {
 public:
  /// Called from the loop.
  struct Events {
    std::function<void(int node, const json::Value& message)> message;  ///< from an agent that serves
    /// All that ran on the node has ended with its agent: the node is lost, or, if is_serving(), has a new agent.
    std::function<void(int node, const std::string& reason)> lost;
    std::function<void(int node)> back;     ///< tasks may be started there (again)
    std::function<void(int node)> missing;  ///< its agent is gone: another may be started before it counts as lost
  };

  /// Listens for agents, and for those who ask the pilot from another host; writes DIR/endpoint.json. `machine`: nodes
  /// by name with their numbers of cores. `address`: this host's. `loop` must outlive the roster.
  static Result<std::unique_ptr<Roster>> listen(RealLoop& loop, const std::filesystem::path& dir, Machine machine,
                                                const std::string& address, Events events);
  ~Roster();  ///< dismisses the agents: they end what still runs

  /// Runs the loop until every node has its agent, some have and no other has come for `patience_s`, or the time is
  /// over. The nodes that have none.
  std::vector<int> await_all(double timeout_s, double patience_s);
  /// From here on nodes are told as lost, those without an agent at once; new agents end only what was theirs.
  void begin();
  void answer(std::function<json::Value(const json::Value& request)> answer);

  /// With the cores that the agents found.
  const Machine& machine() const;
  bool is_serving(int node) const;
  /// It may come back: what runs there is not known.
  bool is_missing(int node) const;
  const std::string& host(int node) const;
  /// Drops a message to a node that does not serve. False: it is too long for a message.
  bool tell(int node, const json::Value& message);

 private:
  struct State;
  explicit Roster(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace granary::pilot
