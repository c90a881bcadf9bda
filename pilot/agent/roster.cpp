#include "pilot/agent/roster.hpp"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "common/log.hpp"
#include "pilot/agent/heart.hpp"
#include "pilot/agent/messages.hpp"
#include "pilot/agent/worker.hpp"
#include "pilot/protocol/endpoint.hpp"
#include "pilot/protocol/listener.hpp"

namespace granary::pilot {

namespace fs = std::filesystem;

namespace {

constexpr double kLook = 0.25;        ///< between looks at who is silent [s]
constexpr double kReviveAfter = 0.7;  ///< a guardian has brought its worker back by then [s]
constexpr double kLastWord = 0.05;    ///< for the agents to be told that they may go [s]

/// A channel's name is its node's and the guardian's own: "node2/1f...".
std::string node_part(const std::string& agent) { return agent.substr(0, agent.find('/')); }

}  // namespace

struct Roster::State {
  /// absent: no agent, and everybody knows. serving: all is well. missing: its agent went, it may come back.
  enum class Presence { absent, serving, missing };
  struct Member {
    Presence presence = Presence::absent;
    Channel* channel = nullptr;
    std::string agent;      ///< name on the channel
    bool is_ready = false;  ///< it has ended what others left
    std::string host;
    double missing_since = 0.0;
    std::string why_missing;
    bool revival_asked = false;
  };

  State(RealLoop& l, fs::path d, Machine m, Events e)
      : loop(l), dir(std::move(d)), machine(std::move(m)), events(std::move(e)), members(machine.nodes.size()) {
    for (std::size_t k = 0; k < machine.nodes.size(); ++k) index_of.emplace(machine.nodes[k].name, static_cast<int>(k));
  }

  RealLoop& loop;
  fs::path dir;
  Machine machine;
  Events events;
  std::vector<Member> members;  ///< by node
  std::map<std::string, int> index_of;
  std::string tag;
  std::unique_ptr<Heart> heart;
  std::unique_ptr<Listener> listener;
  bool begun = false;
  std::function<json::Value(const json::Value&)> answer;
  std::function<void()> someone_came = [] {};
  TimerId look = TimerId::none;

  Member& at(int node) { return members[static_cast<std::size_t>(node)]; }
  int size() const { return static_cast<int>(members.size()); }
  const std::string& name(int node) const { return machine.nodes[static_cast<std::size_t>(node)].name; }

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
            [this, node, &channel](const std::string& why) {
              if (at(node).channel == &channel) gone(node, "its agent is gone: " + why);
            }};
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
    if (at(node).is_ready) events.message(node, message);
  }

  /// An agent of this node: the first, its guardian's next worker, or one started anew.
  void arrived(int node, Channel& channel, const json::Value& message) {
    Member& member = at(node);
    const auto report = report_from_json(message);
    const bool other_lives = member.presence == Presence::serving && member.agent != channel.name() &&
                             heart->silence(member.agent) < kSilence;
    if (!report || other_lives) {
      log::warning("pilot", fmt::format("agent of {} sent away: {}", name(node),
                                        report ? "the node has one" : report.error().message));
      (void)channel.send(json::Value::object({{"do", "bye"}}));
      return;
    }
    if (member.presence == Presence::serving) {
      listener->drop(*member.channel);
      gone(node, "its agent was replaced");
    }
    take_up(node, *report);
    member.channel = &channel;
    member.agent = channel.name();
    member.is_ready = false;
    // Before the first task everything of this campaign is an orphan; later, what this node's agents started.
    (void)channel.send(json::Value::object({{"do", "serve"},
                                            {"cpus", to_json(machine.nodes[static_cast<std::size_t>(node)].cpus)},
                                            {"clean", begun ? agent_entry(tag, name(node)) : agent_entry(tag)}}));
  }

  void take_up(int node, const AgentReport& report) {
    Node& stated = machine.nodes[static_cast<std::size_t>(node)];
    if (report.cpus.size() < stated.cpus.size())
      log::warning("pilot", fmt::format("{}: {} cores were promised, {} are there: they are shared", stated.name,
                                        stated.cpus.size(), report.cpus.size()));
    for (std::size_t k = 0; k < stated.cpus.size(); ++k) stated.cpus[k] = report.cpus[k % report.cpus.size()];
    if (stated.memory_bytes == 0) stated.memory_bytes = report.memory_bytes;
    at(node).host = report.host;
  }

  void ready(int node) {
    Member& member = at(node);
    member.is_ready = true;
    const Presence before = std::exchange(member.presence, Presence::serving);
    if (begun && before == Presence::missing)
      events.lost(node, member.why_missing + "; another is there, what ran was ended");
    if (begun) events.back(node);
    someone_came();
  }

  /// The agent can be reached no more. Its tasks' fate is known when it is back, or when the node counts as lost.
  void gone(int node, const std::string& why) {
    Member& member = at(node);
    member.channel = nullptr;
    member.is_ready = false;
    if (member.presence != Presence::serving) return;
    member.presence = Presence::missing;
    member.missing_since = loop.now();
    member.why_missing = why;
    member.revival_asked = false;
    log::warning("pilot", fmt::format("node {}: {}", name(node), why));
  }

  // --- who lives ---

  void look_around() {
    for (int node = 0; node < size(); ++node) {
      note_silence(node);
      if (begun && at(node).presence == Presence::missing) wait_for(node);
    }
    look = loop.after(kLook, [this] { look_around(); });
  }

  void note_silence(int node) {
    Member& member = at(node);
    if (member.presence != Presence::serving || heart->silence(member.agent) <= kSilence) return;
    // Its guardian has ended its tasks by now. An agent that is still connected is one without a guardian: it ends them
    // when the connection does.
    if (member.channel != nullptr) listener->drop(*member.channel);
    gone(node, fmt::format("nothing was heard of it for {:g} s", kSilence));
    member.missing_since = loop.now() - kSilence;
  }

  void wait_for(int node) {
    Member& member = at(node);
    const double since = loop.now() - member.missing_since;
    if (since > kReviveAfter && !std::exchange(member.revival_asked, true)) events.missing(node);
    if (since < kSilence) return;
    member.presence = Presence::absent;
    log::warning("pilot", fmt::format("node {} is lost: {}", name(node), member.why_missing));
    events.lost(node, member.why_missing);
  }

  std::vector<int> absent() const {
    std::vector<int> list;
    for (int node = 0; node < size(); ++node)
      if (!members[static_cast<std::size_t>(node)].is_ready) list.push_back(node);
    return list;
  }
};

Roster::Roster(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<Roster>> Roster::listen(RealLoop& loop, const fs::path& dir, Machine machine,
                                               const std::string& address, Events events) {
  GRANARY_TRY(const Digest secret, campaign_secret(dir));
  auto state = std::make_unique<State>(loop, dir, std::move(machine), std::move(events));
  State& s = *state;
  s.tag = campaign_tag(secret);
  GRANARY_TRY(s.heart, Heart::beat(address, secret));
  // While agents are connected, something may come at any time.
  GRANARY_TRY(s.listener, Listener::listen(
                              loop, address, secret, [&s](Channel& channel) { return s.welcome(channel); }, true));
  GRANARY_CHECK(write_endpoint(dir, {host_name(), {address, host_name()}, s.listener->port(), s.heart->port()}));
  s.look = loop.after(kLook, [&s] { s.look_around(); });
  return std::unique_ptr<Roster>(new Roster(std::move(state)));
}

Roster::~Roster() {
  State& state = *state_;
  state.loop.cancel(state.look);
  state.begun = false;
  state.answer = nullptr;
  bool any = false;
  for (State::Member& member : state.members) {
    member.presence = State::Presence::absent;  // nobody is to be told that it goes
    if (member.channel == nullptr) continue;
    any = true;
    (void)member.channel->send(json::Value::object({{"do", "bye"}}));
  }
  if (any) {
    state.loop.after(kLastWord, [&state] { state.loop.stop(); });
    state.loop.run();
  }
  std::error_code ignored;
  fs::remove(state.dir / "endpoint.json", ignored);
}

std::vector<int> Roster::await_all(double timeout_s, double patience_s) {
  State& state = *state_;
  TimerId patience = TimerId::none;
  state.someone_came = [&] {
    if (state.absent().empty()) return state.loop.stop();
    state.loop.cancel(patience);
    patience = state.loop.after(patience_s, [&state] { state.loop.stop(); });
  };
  const TimerId limit = state.loop.after(timeout_s, [&state] { state.loop.stop(); });
  if (!state.absent().empty()) state.loop.run();
  state.loop.cancel(limit);
  state.loop.cancel(patience);
  state.someone_came = [] {};
  return state.absent();
}

void Roster::begin() {
  state_->begun = true;
  for (int node = 0; node < state_->size(); ++node)
    if (state_->at(node).presence == State::Presence::absent) state_->events.lost(node, "no agent came from it");
}

void Roster::answer(std::function<json::Value(const json::Value& request)> answer) {
  state_->answer = std::move(answer);
}

const Machine& Roster::machine() const { return state_->machine; }
bool Roster::is_serving(int node) const { return state_->at(node).is_ready; }
bool Roster::is_missing(int node) const { return state_->at(node).presence == State::Presence::missing; }
const std::string& Roster::host(int node) const { return state_->at(node).host; }

bool Roster::tell(int node, const json::Value& message) {
  return !is_serving(node) || state_->at(node).channel->send(message);
}

}  // namespace granary::pilot
