#include "pilot/agent/agent_launcher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <set>

#include "common/log.hpp"
#include "pilot/agent/messages.hpp"
#include "pilot/agent/roster.hpp"
#include "pilot/launch/set_aside.hpp"
#include "pilot/protocol/frame.hpp"

namespace granary::pilot {

struct AgentLauncher::State {
  struct Attempt {
    Launch launch;           ///< as its home is told: with the node's own core numbers
    int home = 0;            ///< the node whose agent started it
    std::vector<int> nodes;  ///< all that it is on, home first
    std::function<void(const RunEnd&)> ended;
    bool is_over = false;    ///< home says so, or is lost
    RunEnd end;              ///< then
    std::set<int> to_clean;  ///< nodes that have not said yet that nothing of it is left there
  };

  explicit State(const Machine& machine) {
    for (std::size_t k = 0; k < machine.nodes.size(); ++k) {
      first_core.push_back(static_cast<int>(node_of.size()));
      node_of.insert(node_of.end(), machine.nodes[k].cpus.size(), static_cast<int>(k));
    }
  }

  std::vector<int> node_of, first_core;  ///< by core; by node
  std::map<AttemptId, Attempt> attempts;
  NodeWatcher watcher;
  std::unique_ptr<Roster> roster;

  // --- placing ---

  int node_with(int core) const { return node_of[static_cast<std::size_t>(core)]; }
  int number_there(int core) const { return core - first_core[static_cast<std::size_t>(node_with(core))]; }

  Attempt placed(const Launch& launch) const {
    Attempt attempt;
    attempt.launch = launch;
    launch.cores.for_each([&](int core) {
      if (attempt.nodes.empty() || attempt.nodes.back() != node_with(core)) attempt.nodes.push_back(node_with(core));
    });
    if (attempt.nodes.empty()) attempt.nodes.push_back(node_for_light());
    attempt.home = attempt.nodes.front();
    attempt.launch.cores = own_cores(launch.cores, attempt.home);
    if (attempt.nodes.size() > 1) attempt.launch.hosts = host_cores(launch.cores);
    return attempt;
  }

  /// Of these cores those on the node, as the node numbers them.
  CoreSet own_cores(const CoreSet& cores, int node) const {
    CoreSet own;
    cores.for_each([&](int core) {
      if (node_with(core) == node) own.add(number_there(core));
    });
    return own;
  }

  std::vector<HostCores> host_cores(const CoreSet& cores) const {
    std::vector<HostCores> hosts;
    int node = -1;
    cores.for_each([&](int core) {
      if (node_with(core) != node) hosts.push_back({roster->host(node_with(core)), {}});
      node = node_with(core);
      const Node& there = roster->machine().nodes[static_cast<std::size_t>(node)];
      hosts.back().cpus.push_back(there.cpus[static_cast<std::size_t>(number_there(core))]);
    });
    return hosts;
  }

  /// The first node that lives: usually the pilot's own.
  int node_for_light() const {
    for (int node = 0; node < static_cast<int>(first_core.size()); ++node)
      if (roster->is_serving(node)) return node;
    return 0;
  }

  Attempt* living(AttemptId id) {
    const auto found = attempts.find(id);
    return found == attempts.end() || found->second.is_over ? nullptr : &found->second;
  }

  void order(const char* what, AttemptId id, json::Value more = json::Value::object()) {
    if (const Attempt* attempt = living(id))
      (void)roster->tell(attempt->home, more.set("do", what).set("id", to_json(id)));
  }

  void signal_elsewhere(AttemptId id, int number) {
    const Attempt* attempt = living(id);
    if (attempt == nullptr) return;
    for (const int node : attempt->nodes)
      if (node != attempt->home)
        (void)roster->tell(
            node, json::Value::object({{"do", "signal_marked"}, {"mark", attempt->launch.mark}, {"signal", number}}));
  }

  // --- ending ---

  void heard(int node, const json::Value& message) {
    const std::string said = message.text_or("say", "");
    const auto id = attempt_from_json(message["id"]);
    if (!id || (said != "ended" && said != "cleaned"))
      return log::warning("pilot", fmt::format("dropped a message of node {} that says \"{}\"", node, said));
    if (said == "cleaned") return cleaned(node, *id);
    if (Attempt* attempt = living(*id)) over(*id, *attempt, end_from_json(message));
  }

  /// Home has nothing of it any more. Unless it ended well, the other nodes are asked whether they have.
  void over(AttemptId id, Attempt& attempt, RunEnd end) {
    attempt.is_over = true;
    attempt.end = std::move(end);
    const bool well = attempt.end.exit_code == 0 && attempt.end.not_started.empty() && attempt.end.lost.empty();
    for (const int node : attempt.nodes)
      if (!well && node != attempt.home) ask_to_clean(id, attempt, node);
    settle(id);
  }

  /// A node that is missing is asked again when it is back; one that is lost has nothing left.
  void ask_to_clean(AttemptId id, Attempt& attempt, int node) {
    attempt.to_clean.erase(node);
    if (!roster->is_serving(node) && !roster->is_missing(node)) return;
    attempt.to_clean.insert(node);
    (void)roster->tell(node,
                       json::Value::object({{"do", "clean"}, {"id", to_json(id)}, {"mark", attempt.launch.mark}}));
  }

  void cleaned(int node, AttemptId id) {
    const auto found = attempts.find(id);
    if (found == attempts.end()) return;
    found->second.to_clean.erase(node);
    settle(id);
  }

  void settle(AttemptId id) {
    const auto found = attempts.find(id);
    if (found == attempts.end() || !found->second.is_over || !found->second.to_clean.empty()) return;
    const auto node = attempts.extract(found);
    node.mapped().ended(node.mapped().end);
  }

  void lost(int node, const std::string& reason) {
    std::vector<AttemptId> here;
    for (const auto& [id, attempt] : attempts)
      if (std::count(attempt.nodes.begin(), attempt.nodes.end(), node) != 0) here.push_back(id);
    watcher.lost(node, reason);  // first: it kills what is left of them on other nodes
    for (const AttemptId id : here) {
      const auto found = attempts.find(id);
      if (found == attempts.end()) continue;
      Attempt& attempt = found->second;
      if (attempt.nodes.size() == 1 && !attempt.launch.cores.empty()) {
        attempts.erase(found);
      } else if (attempt.home == node && !attempt.is_over) {
        RunEnd end;
        end.lost = "its node was lost: " + reason;
        over(id, attempt, std::move(end));
      } else if (attempt.to_clean.count(node) != 0) {
        ask_to_clean(id, attempt, node);
        settle(id);
      }
    }
  }
};

AgentLauncher::AgentLauncher(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<AgentLauncher>> AgentLauncher::listen(RealLoop& loop, const std::filesystem::path& dir,
                                                             Machine machine, const std::string& address) {
  auto state = std::make_unique<State>(machine);
  Roster::Events events{[s = state.get()](int node, const json::Value& message) { s->heard(node, message); },
                        [s = state.get()](int node, const std::string& reason) { s->lost(node, reason); },
                        [s = state.get()](int node) { s->watcher.back(node); },
                        [s = state.get()](int node) { s->watcher.missing(node); }};
  GRANARY_TRY(state->roster, Roster::listen(loop, dir, std::move(machine), address, std::move(events)));
  return std::unique_ptr<AgentLauncher>(new AgentLauncher(std::move(state)));
}

AgentLauncher::~AgentLauncher() {
  state_->attempts.clear();  // nobody is to be told of their ends
}

std::vector<int> AgentLauncher::await_agents(double timeout_s, double patience_s) {
  return state_->roster->await_all(timeout_s, patience_s);
}
const Machine& AgentLauncher::machine() const { return state_->roster->machine(); }

void AgentLauncher::watch(NodeWatcher watcher) {
  state_->watcher = std::move(watcher);
  state_->roster->begin();
}

void AgentLauncher::answer(std::function<json::Value(const json::Value& request)> answer) {
  state_->roster->answer(std::move(answer));
}

Result<ProcessKey> AgentLauncher::start(const Launch& launch, std::function<void(const RunEnd&)> ended) {
  State::Attempt attempt = state_->placed(launch);
  attempt.ended = std::move(ended);
  // To a node that is missing nothing is sent: when it is back, or lost, the task is queued again.
  if (!state_->roster->tell(attempt.home, to_json(attempt.launch).set("do", "start")))
    return Error{fmt::format("its command and environment are longer than a message to an agent may be ({} bytes)",
                             kLargestPayload),
                 Exit::task_failed};
  state_->attempts.insert_or_assign(launch.attempt, std::move(attempt));
  return ProcessKey{};
}

void AgentLauncher::signal(AttemptId id, int signal_number) {
  state_->order("signal", id, json::Value::object({{"signal", signal_number}}));
}

void AgentLauncher::kill(AttemptId id) { state_->order("kill", id); }

void AgentLauncher::suspend(AttemptId id) {
  state_->order("suspend", id);
  state_->signal_elsewhere(id, SIGSTOP);
}

void AgentLauncher::resume(AttemptId id, const CoreSet& cores) {
  if (const State::Attempt* attempt = state_->living(id))
    state_->order("resume", id,
                  json::Value::object({{"cores", to_json(state_->own_cores(cores, attempt->home).list())}}));
  state_->signal_elsewhere(id, SIGCONT);
}

Status AgentLauncher::set_aside(const Launch& earlier, bool own_folder) {
  return set_aside_attempt(earlier, own_folder);
}

bool AgentLauncher::end_orphan(const ProcessKey&, const std::string&) { return false; }

}  // namespace granary::pilot
