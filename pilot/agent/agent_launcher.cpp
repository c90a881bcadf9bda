#include "pilot/agent/agent_launcher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <set>

#include "common/log.hpp"
#include "pilot/agent/heart.hpp"
#include "pilot/agent/messages.hpp"
#include "pilot/agent/worker.hpp"
#include "pilot/launch/set_aside.hpp"
#include "pilot/protocol/endpoint.hpp"
#include "pilot/protocol/frame.hpp"
#include "pilot/protocol/listener.hpp"

namespace granary::pilot {

namespace fs = std::filesystem;

namespace {

constexpr double kLook = 0.25;        ///< between looks at who is silent [s]
constexpr double kReviveAfter = 0.7;  ///< a guardian has brought its worker back by then [s]

/// Its node's name and the guardian's own: "node2/1f...".
std::string node_part(const std::string& agent) { return agent.substr(0, agent.find('/')); }

}  // namespace

struct AgentLauncher::State {
  /// absent: no agent, and the pilot knows. serving: all is well. missing: its agent went, it may come back.
  enum class Presence { absent, serving, missing };
  struct NodeState {
    Presence presence = Presence::absent;
    Channel* channel = nullptr;
    std::string agent;      ///< name of the agent on the channel
    bool is_ready = false;  ///< the agent has ended what others left
    std::string host;
    double missing_since = 0.0;
    std::string why_missing;
    bool revival_asked = false;
  };
  struct Attempt {
    Launch launch;
    int home = 0;
    std::vector<int> nodes;  ///< all that it is on, home first
    std::function<void(const RunEnd&)> ended;
    bool is_over = false;          ///< home says so, or is lost
    RunEnd end;                    ///< then
    std::set<int> still_to_clean;  ///< nodes that have not said yet that nothing of it is left there
  };

  State(RealLoop& l, fs::path d, Machine m) : loop(l), dir(std::move(d)), machine(std::move(m)) {
    nodes.resize(machine.nodes.size());
    for (std::size_t k = 0; k < machine.nodes.size(); ++k) {
      index_of.emplace(machine.nodes[k].name, static_cast<int>(k));
      first_core.push_back(n_cores);
      const int count = static_cast<int>(machine.nodes[k].cpus.size());
      n_cores += count;
      for (int c = 0; c < count; ++c) node_of.push_back(static_cast<int>(k));
    }
  }

  RealLoop& loop;
  fs::path dir;
  Machine machine;
  std::vector<int> node_of, first_core;  ///< by core; by node
  int n_cores = 0;
  std::map<std::string, int> index_of;
  std::vector<NodeState> nodes;
  std::map<AttemptId, Attempt> attempts;
  std::string tag;
  std::unique_ptr<Heart> heart;
  std::unique_ptr<Listener> listener;
  NodeWatcher watcher;
  bool watching = false;
  std::function<json::Value(const json::Value&)> answer;
  std::function<void()> someone_came = [] {};
  TimerId look = TimerId::none;

  NodeState& at(int node) { return nodes[static_cast<std::size_t>(node)]; }
  const std::string& name(int node) const { return machine.nodes[static_cast<std::size_t>(node)].name; }
  bool is_serving(int node) { return at(node).presence == Presence::serving && at(node).is_ready; }

  // --- connections ---

  Listener::Guest welcome(Channel& channel) {
    if (channel.role() == Role::client) return client(channel);
    const auto found = index_of.find(node_part(channel.name()));
    if (channel.role() != Role::agent || found == index_of.end()) {
      log::warning("pilot", fmt::format("an agent of no node of ours: {}", channel.name()));
      return {};
    }
    const int node = found->second;
    return {[this, node, &channel](const json::Value& message) { heard(node, channel, message); },
            [this, node, &channel](const std::string& why) { closed(node, channel, why); }};
  }

  Listener::Guest client(Channel& channel) {
    return {[this, &channel](const json::Value& request) {
              const auto refuse = [](const char* why) { return json::Value::object({{"error", why}}); };
              if (!channel.send(answer ? answer(request) : refuse("the pilot is just starting")))
                channel.send(refuse("the answer is too long to be sent"));
            },
            {}};
  }

  void heard(int node, Channel& channel, const json::Value& message) {
    const std::string said = message.text_or("say", "");
    if (said == "here") return arrived(node, channel, message);
    if (at(node).channel != &channel) return;  // of an agent that was replaced
    if (said == "ready") return ready(node);
    if (said == "ended") return ended(message);
    if (said == "cleaned") return cleaned(node, message.integer_or("ticket", -1));
    log::warning("pilot", fmt::format("agent of {}: dropped a message that says \"{}\"", name(node), said));
  }

  /// An agent of this node: the first, its guardian's next worker, or one started anew.
  void arrived(int node, Channel& channel, const json::Value& message) {
    NodeState& state = at(node);
    const auto report = report_from_json(message);
    const bool other_lives =
        state.presence == Presence::serving && state.agent != channel.name() && heart->silence(state.agent) < kSilence;
    if (!report || other_lives) {
      log::warning("pilot", fmt::format("agent of {} sent away: {}", name(node),
                                        report ? "the node has one" : report.error().message));
      (void)channel.send(json::Value::object({{"do", "bye"}}));
      return;
    }
    if (state.presence == Presence::serving) {
      listener->drop(*state.channel);
      gone(node, "its agent was replaced");
    }
    Node& stated = machine.nodes[static_cast<std::size_t>(node)];
    if (report->cpus.size() < stated.cpus.size())
      log::warning("pilot", fmt::format("{}: {} cores were promised, {} are there: they are shared", stated.name,
                                        stated.cpus.size(), report->cpus.size()));
    for (std::size_t k = 0; k < stated.cpus.size(); ++k) stated.cpus[k] = report->cpus[k % report->cpus.size()];
    if (stated.memory_bytes == 0) stated.memory_bytes = report->memory_bytes;
    state.host = report->host;
    state.channel = &channel;
    state.agent = channel.name();
    state.is_ready = false;
    // Before the first task everything of this campaign is an orphan; later, what this node's agents started.
    channel.send(json::Value::object({{"do", "serve"},
                                      {"cpus", to_json(stated.cpus)},
                                      {"clean", watching ? agent_entry(tag, name(node)) : agent_entry(tag)}}));
  }

  void ready(int node) {
    NodeState& state = at(node);
    state.is_ready = true;
    const Presence before = std::exchange(state.presence, Presence::serving);
    if (watching) {
      if (before == Presence::missing) lose(node, state.why_missing + "; it is back, its tasks were ended");
      if (watcher.back) watcher.back(node);
    }
    someone_came();
  }

  void closed(int node, Channel& channel, const std::string& why) {
    if (at(node).channel == &channel) gone(node, "its agent is gone: " + why);
  }

  /// The agent can be reached no more. Its tasks' fate is known when it is back, or when the node counts as lost.
  void gone(int node, const std::string& why) {
    NodeState& state = at(node);
    state.channel = nullptr;
    state.is_ready = false;
    if (state.presence != Presence::serving) return;
    state.presence = Presence::missing;
    state.missing_since = loop.now();
    state.why_missing = why;
    state.revival_asked = false;
    log::warning("pilot", fmt::format("node {}: {}", name(node), why));
  }

  // --- who lives ---

  void look_around() {
    for (int node = 0; node < static_cast<int>(nodes.size()); ++node) {
      NodeState& state = at(node);
      if (state.presence == Presence::serving && heart->silence(state.agent) > kSilence) {
        // Its guardian has ended its tasks by now. An agent that is still connected is one without a guardian: it ends
        // them when the connection does.
        if (state.channel != nullptr) listener->drop(*state.channel);
        gone(node, fmt::format("nothing was heard of it for {:g} s", kSilence));
        state.missing_since = loop.now() - kSilence;
      }
      if (state.presence != Presence::missing || !watching) continue;
      const double since = loop.now() - state.missing_since;
      if (since > kReviveAfter && !std::exchange(state.revival_asked, true) && watcher.missing) watcher.missing(node);
      if (since < kSilence) continue;
      state.presence = Presence::absent;
      lose(node, state.why_missing);
    }
    look = loop.after(kLook, [this] { look_around(); });
  }

  /// Whatever ran on the node has ended with its agent's session: the pilot is told, what ran elsewhere too is tidied
  /// up.
  void lose(int node, const std::string& reason) {
    std::vector<AttemptId> here;
    for (auto& [id, attempt] : attempts)
      if (std::count(attempt.nodes.begin(), attempt.nodes.end(), node) != 0) here.push_back(id);
    // First: it kills what is left of them on other nodes.
    if (watcher.lost) watcher.lost(node, reason);
    for (const AttemptId id : here) {
      const auto found = attempts.find(id);
      if (found == attempts.end()) continue;
      Attempt& attempt = found->second;
      if (attempt.nodes.size() == 1 && !attempt.launch.cores.empty()) {
        attempts.erase(found);  // the pilot knows what it lost with the node
      } else if (attempt.home == node && !attempt.is_over) {
        RunEnd end;
        end.lost = fmt::format("node {} was lost: {}", name(node), reason);
        over(id, attempt, std::move(end));
      } else if (attempt.still_to_clean.count(node) != 0) {
        ask_to_clean(id, attempt, node);
        settle(id);
      }
    }
  }

  // --- attempts ---

  void signal_elsewhere(const Attempt& attempt, int number) {
    for (const int node : attempt.nodes)
      if (node != attempt.home)
        tell(node, json::Value::object({{"do", "signal_marked"}, {"mark", attempt.launch.mark}, {"signal", number}}));
  }

  json::Value order(const char* what, AttemptId attempt) {
    return json::Value::object({{"do", what}, {"id", to_json(attempt)}});
  }

  /// False: it is too long for a message.
  bool tell(int node, const json::Value& message) { return !is_serving(node) || at(node).channel->send(message); }

  Attempt* living(AttemptId id) {
    const auto found = attempts.find(id);
    return found == attempts.end() || found->second.is_over ? nullptr : &found->second;
  }

  Attempt placed(const Launch& launch) {
    Attempt attempt;
    attempt.launch = launch;
    for (const int core : launch.cores) {
      const int node = node_of[static_cast<std::size_t>(core)];
      if (attempt.nodes.empty() || attempt.nodes.back() != node) attempt.nodes.push_back(node);
    }
    if (attempt.nodes.empty()) attempt.nodes.push_back(node_for_light());
    attempt.home = attempt.nodes.front();
    const bool several = attempt.nodes.size() > 1;
    for (const int node : attempt.nodes)
      if (several) attempt.launch.hosts.push_back({at(node).host, {}});
    for (const int core : launch.cores) {
      const int node = node_of[static_cast<std::size_t>(core)];
      const int local = core - first_core[static_cast<std::size_t>(node)];
      if (!several) continue;
      const auto share = std::find(attempt.nodes.begin(), attempt.nodes.end(), node) - attempt.nodes.begin();
      attempt.launch.hosts[static_cast<std::size_t>(share)].cpus.push_back(
          machine.nodes[static_cast<std::size_t>(node)].cpus[static_cast<std::size_t>(local)]);
    }
    attempt.launch.cores = own_cores(launch.cores, attempt.home);
    return attempt;
  }

  /// Of these cores those on the node, as the node numbers them.
  std::vector<int> own_cores(const std::vector<int>& cores, int node) const {
    std::vector<int> own;
    for (const int core : cores)
      if (node_of[static_cast<std::size_t>(core)] == node)
        own.push_back(core - first_core[static_cast<std::size_t>(node)]);
    return own;
  }

  /// The first node that lives: usually the pilot's own.
  int node_for_light() {
    for (int node = 0; node < static_cast<int>(nodes.size()); ++node)
      if (is_serving(node)) return node;
    return 0;
  }

  void ended(const json::Value& message) {
    const auto id = attempt_from_json(message["id"]);
    Attempt* attempt = id ? living(*id) : nullptr;
    if (attempt != nullptr) over(*id, *attempt, end_from_json(message));
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

  /// A node that is missing answers when it is back; one that is lost has nothing left.
  void ask_to_clean(AttemptId id, Attempt& attempt, int node) {
    if (at(node).presence == Presence::absent) {
      attempt.still_to_clean.erase(node);
      return;
    }
    attempt.still_to_clean.insert(node);
    tell(node, json::Value::object({{"do", "clean"}, {"mark", attempt.launch.mark}, {"ticket", ticket_of(id)}}));
  }

  static std::int64_t ticket_of(AttemptId id) { return std::int64_t{id.task.value} * 1'000'000 + id.number; }

  void cleaned(int node, std::int64_t ticket) {
    const AttemptId id{{static_cast<int>(ticket / 1'000'000)}, static_cast<int>(ticket % 1'000'000)};
    const auto found = attempts.find(id);
    if (found == attempts.end()) return;
    found->second.still_to_clean.erase(node);
    settle(id);
  }

  void settle(AttemptId id) {
    const auto found = attempts.find(id);
    if (found == attempts.end() || !found->second.is_over || !found->second.still_to_clean.empty()) return;
    const auto node = attempts.extract(found);
    node.mapped().ended(node.mapped().end);
  }
};

AgentLauncher::AgentLauncher(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<AgentLauncher>> AgentLauncher::listen(RealLoop& loop, const fs::path& dir, Machine machine,
                                                             const std::string& address) {
  GRANARY_TRY(const Digest secret, campaign_secret(dir));
  auto state = std::make_unique<State>(loop, dir, std::move(machine));
  State& s = *state;
  s.tag = campaign_tag(secret);
  GRANARY_TRY(s.heart, Heart::beat(address, secret));
  // While agents are connected, something may come at any time.
  GRANARY_TRY(s.listener, Listener::listen(
                              loop, address, secret, [&s](Channel& channel) { return s.welcome(channel); }, true));
  GRANARY_CHECK(write_endpoint(dir, {host_name(), {address, host_name()}, s.listener->port(), s.heart->port()}));
  s.look = loop.after(kLook, [&s] { s.look_around(); });
  return std::unique_ptr<AgentLauncher>(new AgentLauncher(std::move(state)));
}

AgentLauncher::~AgentLauncher() {
  State& state = *state_;
  state.loop.cancel(state.look);
  state.watching = false;
  state.answer = nullptr;
  bool any = false;
  for (State::NodeState& node : state.nodes) {
    if (node.channel == nullptr) continue;
    node.channel->send(json::Value::object({{"do", "bye"}}));
    node.presence = State::Presence::absent;  // nobody is to be told that it goes
    any = true;
  }
  if (any) {
    // One turn, so that it leaves.
    state.loop.after(0.05, [&state] { state.loop.stop(); });
    state.loop.run();
  }
  std::error_code ignored;
  fs::remove(state.dir / "endpoint.json", ignored);
}

std::vector<int> AgentLauncher::await_agents(double timeout_s) {
  State& state = *state_;
  const auto absent = [&state] {
    std::vector<int> list;
    for (int node = 0; node < static_cast<int>(state.nodes.size()); ++node)
      if (!state.is_serving(node)) list.push_back(node);
    return list;
  };
  state.someone_came = [&] {
    if (absent().empty()) state.loop.stop();
  };
  const TimerId limit = state.loop.after(timeout_s, [&state] { state.loop.stop(); });
  if (!absent().empty()) state.loop.run();
  state.loop.cancel(limit);
  state.someone_came = [] {};
  return absent();
}

const Machine& AgentLauncher::machine() const { return state_->machine; }

void AgentLauncher::watch(NodeWatcher watcher) {
  State& state = *state_;
  state.watcher = std::move(watcher);
  state.watching = true;
  for (int node = 0; node < static_cast<int>(state.nodes.size()); ++node) {
    if (state.at(node).presence == State::Presence::absent && state.watcher.lost)
      state.watcher.lost(node, "no agent came from it");
  }
}

void AgentLauncher::answer(std::function<json::Value(const json::Value& request)> answer) {
  state_->answer = std::move(answer);
}

Result<ProcessKey> AgentLauncher::start(const Launch& launch, std::function<void(const RunEnd&)> ended) {
  State& state = *state_;
  State::Attempt attempt = state.placed(launch);
  attempt.ended = std::move(ended);
  // To a node that is missing nothing is sent: when it is back, or lost, the task is queued again.
  if (!state.tell(attempt.home, to_json(attempt.launch).set("do", "start")))
    return Error{fmt::format("its command and environment are longer than a message to an agent may be ({} bytes)",
                             kLargestPayload),
                 Exit::task_failed};
  state.attempts.insert_or_assign(launch.attempt, std::move(attempt));
  return ProcessKey{};
}

void AgentLauncher::signal(AttemptId id, int signal_number) {
  if (const State::Attempt* attempt = state_->living(id))
    state_->tell(attempt->home, state_->order("signal", id).set("signal", signal_number));
}

void AgentLauncher::kill(AttemptId id) {
  if (const State::Attempt* attempt = state_->living(id)) state_->tell(attempt->home, state_->order("kill", id));
}

void AgentLauncher::suspend(AttemptId id) {
  const State::Attempt* attempt = state_->living(id);
  if (attempt == nullptr) return;
  state_->tell(attempt->home, state_->order("suspend", id));
  state_->signal_elsewhere(*attempt, SIGSTOP);
}

void AgentLauncher::resume(AttemptId id, const std::vector<int>& cores) {
  const State::Attempt* attempt = state_->living(id);
  if (attempt == nullptr) return;
  state_->tell(attempt->home,
               state_->order("resume", id).set("cores", to_json(state_->own_cores(cores, attempt->home))));
  state_->signal_elsewhere(*attempt, SIGCONT);
}

Status AgentLauncher::set_aside(const Launch& earlier, bool own_folder) {
  return set_aside_attempt(earlier, own_folder);
}

bool AgentLauncher::end_orphan(const ProcessKey&, const std::string&) { return false; }

}  // namespace granary::pilot
