#include "pilot/agent/worker.hpp"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <optional>

#include "common/log.hpp"
#include "pilot/agent/messages.hpp"
#include "pilot/launch/local_launcher.hpp"
#include "pilot/launch/marked.hpp"
#include "pilot/protocol/channel.hpp"
#include "pilot/protocol/endpoint.hpp"
#include "pilot/protocol/frame.hpp"
#include "pilot/protocol/tcp.hpp"

namespace granary::pilot {
namespace {

constexpr double kConnectTime = 5.0;  ///< [s]
constexpr int kMostCores = 1 << 16;

class Worker {
 public:
  Worker(const WorkerOptions& options, std::string tag, AgentReport report)
      : options_(options), tag_(std::move(tag)), report_(std::move(report)) {}

  WorkerEnd run(int fd, const Digest& secret) {
    loop_.on_signals({SIGTERM}, [this](int) { end(WorkerEnd::lost_pilot, "its guardian is gone"); });
    const std::string name = options_.node + "/" + options_.instance;
    channel_.emplace(loop_, fd, Handshake::call(secret, Role::agent, name),
                     Channel::Events{[this] { say("here", to_json(report_)); },
                                     [this](const json::Value& message) { take(message); },
                                     [this](const std::string& why) { end(WorkerEnd::lost_pilot, why); }});
    loop_.run();
    launcher_.reset();  // kills what still runs
    end_processes_with(agent_entry(tag_, options_.node, options_.instance));
    return end_;
  }

 private:
  void end(WorkerEnd how, const std::string& why) {
    if (how == WorkerEnd::lost_pilot) log::warning("agent", fmt::format("{}: pilot lost: {}", options_.node, why));
    end_ = how;
    loop_.stop();
  }

  void say(const char* what, json::Value more) { channel_->send(more.set("say", what)); }

  void take(const json::Value& message) {
    const std::string wanted = message.text_or("do", "");
    if (wanted == "bye") return end(WorkerEnd::dismissed, "");
    if (wanted == "serve") return serve(message);
    if (!launcher_) return;
    if (wanted == "start") return start(message);
    if (wanted == "clean") return clean(message.text_or("mark", ""), message["id"], kCleanLooks);
    if (wanted == "signal_marked")
      return signal_marked(message.text_or("mark", "?"), static_cast<int>(message.integer_or("signal", 0)));
    const auto attempt = attempt_from_json(message["id"]);
    if (!attempt) return log::warning("agent", "dropped a message: " + attempt.error().message);
    if (wanted == "signal") launcher_->signal(*attempt, static_cast<int>(message.integer_or("signal", 0)));
    if (wanted == "kill") launcher_->kill(*attempt);
    if (wanted == "suspend") launcher_->suspend(*attempt);
    if (wanted == "resume") {
      const auto cores = numbers_from_json(message["cores"], n_cores_);
      if (cores) launcher_->resume(*attempt, *cores);
    }
  }

  /// The pilot takes us: what earlier agents left on this node is ended before it sends anything.
  void serve(const json::Value& message) {
    const auto cpus = numbers_from_json(message["cpus"], kMostCores);
    if (!cpus || launcher_) return;
    const bool any = end_processes_with(message.text_or("clean", "?"));
    setenv("GRANARY_AGENT", agent_entry(tag_, options_.node, options_.instance).substr(sizeof "GRANARY_AGENT").c_str(),
           1);
    n_cores_ = static_cast<int>(cpus->size());
    launcher_.emplace(loop_, Machine{{Node{options_.node, *cpus, report_.memory_bytes}}});
    say("ready", json::Value::object({{"ended_orphans", any}}));
  }

  void start(const json::Value& message) {
    const auto launch = launch_from_json(message);
    if (!launch) return log::warning("agent", "dropped a message: " + launch.error().message);
    const AttemptId attempt = launch->attempt;
    for (const int core : launch->cores.list())
      if (core >= n_cores_) return ended(attempt, not_started("the pilot named a core that this node does not have"));
    const auto started = launcher_->start(*launch, [this, attempt](const RunEnd& end) { ended(attempt, end); });
    if (!started) ended(attempt, not_started(started.error().message));
  }

  static RunEnd not_started(const std::string& why) {
    RunEnd end;
    end.not_started = why;
    return end;
  }

  void ended(AttemptId attempt, const RunEnd& end) {
    json::Value message = to_json(end);
    say("ended", message.set("id", to_json(attempt)));
  }

  /// Ends what an attempt of another node has here, and says when it is gone.
  void clean(const std::string& mark, const json::Value& id, int looks_left) {
    const std::vector<int> pids = marked_processes(mark);
    if (pids.empty() || looks_left == 0) return say("cleaned", json::Value::object({{"id", id}}));
    for (const int pid : pids) ::kill(pid, SIGKILL);
    loop_.after(kCleanPause, [this, mark, id, looks_left] { clean(mark, id, looks_left - 1); });
  }

  static constexpr int kCleanLooks = 400;
  static constexpr double kCleanPause = 0.005;  ///< [s]

  const WorkerOptions& options_;
  std::string tag_;
  AgentReport report_;
  RealLoop loop_;
  std::optional<Channel> channel_;
  std::optional<LocalLauncher> launcher_;  ///< once the pilot has taken us
  int n_cores_ = 0;
  WorkerEnd end_ = WorkerEnd::lost_pilot;
};

}  // namespace

std::string agent_entry(const std::string& tag, const std::string& node, const std::string& instance) {
  std::string entry = "GRANARY_AGENT=" + tag + "/";
  if (!node.empty()) entry += node + "/";
  if (!instance.empty()) entry += instance + "/";
  return entry;
}

Result<WorkerEnd> run_worker(const WorkerOptions& options) {
  // Without its guardian nobody would tell the pilot that this node lives.
  (void)prctl(PR_SET_PDEATHSIG, SIGTERM);
  GRANARY_TRY(const Endpoint endpoint, read_endpoint(options.dir));
  GRANARY_TRY(const Digest secret, read_secret(options.dir));
  GRANARY_TRY(const Machine machine, local_machine());
  const Node& node = machine.nodes.front();
  const auto fd = endpoint.port == options.port ? connect_tcp(endpoint.addresses, options.port, kConnectTime)
                                                : Result<int>(Error{"another pilot is there now"});
  if (!fd) {
    log::warning("agent", fmt::format("{}: {}", options.node, fd.error().message));
    return WorkerEnd::no_pilot;
  }
  Worker worker(options, campaign_tag(secret), {host_name(), node.cpus, node.memory_bytes, static_cast<int>(getpid())});
  return worker.run(*fd, secret);
}

}  // namespace granary::pilot
