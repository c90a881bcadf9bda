#include "pilot/agent/guardian.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <optional>

#include "common/files.hpp"
#include "common/log.hpp"
#include "pilot/agent/heart.hpp"
#include "pilot/agent/worker.hpp"
#include "pilot/launch/marked.hpp"
#include "pilot/launch/spawn.hpp"
#include "pilot/protocol/channel.hpp"
#include "pilot/protocol/endpoint.hpp"
#include "pilot/protocol/tcp.hpp"

extern char** environ;

namespace granary::pilot {
namespace {

constexpr int kMostWorkers = 20;        ///< a worker that dies again and again is no use
constexpr double kReconnectTime = 0.5;  ///< [s]

class Guardian {
 public:
  Guardian(std::filesystem::path dir, std::string node, Endpoint endpoint, const Digest& secret)
      : dir_(std::move(dir)), node_(std::move(node)), endpoint_(std::move(endpoint)), secret_(secret) {}

  Status run() {
    loop_.on_signals({SIGTERM, SIGINT, SIGHUP}, [this](int) { finish(); });
    GRANARY_CHECK(start_worker());
    connect();
    loop_.after(kBeat, [this] { beat(); });
    loop_.run();
    if (worker_) end_worker();
    return {};
  }

 private:
  // --- the worker ---

  Status start_worker() {
    if (++n_workers_ > kMostWorkers)
      return Error{fmt::format("{}: {} workers of this node died; no more are started", node_, kMostWorkers),
                   Exit::internal};
    SpawnRequest request;
    request.file = "/proc/self/exe";
    request.argv = {"granary-agent", "--worker", dir_.string(), node_, instance_, std::to_string(endpoint_.port)};
    for (char** entry = environ; *entry != nullptr; ++entry) request.env.emplace_back(*entry);
    request.stdout_fd = STDOUT_FILENO;
    request.stderr_fd = STDERR_FILENO;
    GRANARY_TRY(worker_, spawn(request));
    loop_.watch(worker_->pidfd, [this] { worker_ended(); });
    return {};
  }

  void worker_ended() {
    loop_.unwatch(worker_->pidfd);
    const ProcessEnd end = reap(worker_->pidfd);
    close(worker_->pidfd);
    worker_.reset();
    end_tasks();
    if (end.exit_code == static_cast<int>(WorkerEnd::dismissed) ||
        end.exit_code == static_cast<int>(WorkerEnd::no_pilot))
      return finish();
    log::warning("agent", fmt::format("{}: the worker ended ({}); its tasks were ended, the next one starts", node_,
                                      end.signal != 0 ? fmt::format("signal {}", end.signal)
                                                      : fmt::format("exit code {}", end.exit_code)));
    if (const Status started = start_worker(); !started) {
      log::error("agent", started.error().message);
      finish();
    }
  }

  void end_worker() {
    loop_.unwatch(worker_->pidfd);
    ::kill(worker_->pid, SIGKILL);
    (void)reap(worker_->pidfd);
    close(worker_->pidfd);
    worker_.reset();
    end_tasks();
  }

  void end_tasks() { end_processes_with(agent_entry(campaign_tag(secret_), node_, instance_)); }

  void finish() { loop_.stop(); }

  // --- the heart ---

  void connect() {
    const auto fd = connect_tcp(endpoint_.addresses, endpoint_.heart_port, kReconnectTime);
    if (!fd) return lost();
    channel_.emplace(
        loop_, *fd, Handshake::call(secret_, Role::heart, node_ + "/" + instance_),
        Channel::Events{[this] { say(); },
                        [this](const json::Value& beat) { heard_ = std::max(heard_, beat.number_or("beat", 0.0)); },
                        [this](const std::string&) { lost(); }});
  }

  void lost() {
    loop_.after(kReconnectTime, [this] { connect(); });
  }

  void say() { channel_->send(json::Value::object({{"beat", loop_.now()}})); }

  void beat() {
    if (channel_) say();
    // A worker that somebody stopped would keep its node looking alive and idle: go on. To any other it is nothing.
    if (worker_) ::kill(worker_->pid, SIGCONT);
    if (loop_.now() - heard_ > kLease) {
      // The pilot may start our tasks elsewhere from now on.
      log::warning("agent",
                   fmt::format("{}: the pilot has not heard of us for {:g} s: tasks are ended", node_, kLease));
      heard_ = loop_.now();  // a full lease for the next worker to find the pilot, or to see that there is none
      if (worker_) end_worker();
      if (const Status started = start_worker(); !started) return finish();
    }
    loop_.after(kBeat, [this] { beat(); });
  }

  std::filesystem::path dir_;
  std::string node_;
  std::string instance_ = campaign_tag(random_digest());  ///< this guardian's own, never seen before
  Endpoint endpoint_;
  Digest secret_;
  RealLoop loop_;
  std::optional<Channel> channel_;
  std::optional<Spawned> worker_;
  int n_workers_ = 0;
  double heard_ = 0.0;  ///< our time of the last beat the pilot is known to have heard
};

}  // namespace

Status run_guardian(const std::filesystem::path& dir, const std::string& node) {
  GRANARY_TRY(Endpoint endpoint, read_endpoint(dir));
  GRANARY_TRY(const Digest secret, read_secret(dir));
  Guardian guardian(dir, node, std::move(endpoint), secret);
  return guardian.run();
}

}  // namespace granary::pilot
