#include "pilot/agent/node_block.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <map>

#include "common/files.hpp"
#include "common/log.hpp"
#include "pilot/agent/slurm_job.hpp"
#include "pilot/launch/command.hpp"
#include "pilot/launch/spawn.hpp"

extern char** environ;

namespace granary::pilot {

namespace fs = std::filesystem;

namespace {

constexpr double kArrival = 60.0;  ///< agents come within this time of their start, or not at all [s]
/// Who is late by so much after the others is done without, and taken when it comes [s].
constexpr double kPatience = 3.0;
/// A step of Slurm ends on all its nodes if it cannot be started on one of them, 11 s later: so each node has its own,
/// as far as that is cheap.
constexpr std::size_t kMostSteps = 32;
constexpr double kRetryEvery = 20.0;  ///< between tries to bring an agent back to a lost node [s]
constexpr double kFarewell = 3.0;     ///< for the agents to end after the last word [s]

}  // namespace

struct NodeBlock::State {
  explicit State(RealLoop& l, fs::path d) : loop(l), dir(std::move(d)) {}

  RealLoop& loop;
  fs::path dir;
  std::unique_ptr<AgentLauncher> launcher;
  std::optional<SlurmJob> job;
  std::map<int, int> starters;     ///< pid by pidfd of each srun or agent that lives
  bool awaiting = false;           ///< the first agents
  std::map<int, TimerId> retries;  ///< by node that is lost

  Status check_program() const {
    GRANARY_TRY(const std::string found, find_executable(agent_program(), "", ""));
    return {};
  }
  std::string agent_program() const { return (program_folder() / "granary-agent").string(); }

  /// srun, or an agent itself. Their words go where ours go.
  Status start(std::vector<std::string> argv) {
    SpawnRequest request;
    const char* path = std::getenv("PATH");
    GRANARY_TRY(request.file, find_executable(argv[0], "", path != nullptr ? path : ""));
    request.argv = std::move(argv);
    for (char** entry = environ; *entry != nullptr; ++entry) request.env.emplace_back(*entry);
    request.stdout_fd = STDERR_FILENO;
    request.stderr_fd = STDERR_FILENO;
    GRANARY_TRY(const Spawned process, spawn(request));
    starters.emplace(process.pidfd, process.pid);
    loop.watch(
        process.pidfd, [this, fd = process.pidfd] { starter_ended(fd); }, false);
    return {};
  }

  void starter_ended(int fd) {
    loop.unwatch(fd);
    (void)reap(fd);
    close(fd);
    starters.erase(fd);
    if (awaiting && starters.empty()) loop.stop();  // nobody comes any more
  }

  std::vector<std::string> srun(std::size_t count, const std::string& where) const {
    const std::string n = std::to_string(count);
    std::vector<std::string> argv{"srun",      "--jobid=" + job->id,  "--job-name=granary-agents",
                                  "--overlap", "--no-kill",           "--kill-on-bad-exit=0",
                                  "--wait=0",  "--input=none",        "--cpu-bind=none",
                                  "--mem=0",   "--ntasks-per-node=1", "-N" + n,
                                  "-n" + n,    "--mpi=none",          "--nodelist=" + where};
    argv.insert(argv.end(), {agent_program(), dir.string()});
    return argv;
  }

  Status start_steps() {
    const std::vector<Node>& nodes = launcher->machine().nodes;
    const std::size_t each = (nodes.size() + kMostSteps - 1) / kMostSteps;
    for (std::size_t begin = 0; begin < nodes.size(); begin += each) {
      const std::size_t end = std::min(begin + each, nodes.size());
      std::string where;
      for (std::size_t k = begin; k < end; ++k) where += (where.empty() ? "" : ",") + nodes[k].name;
      GRANARY_CHECK(start(srun(end - begin, where)));
    }
    return {};
  }

  /// What starts one node's agent.
  std::vector<std::string> starter_of(int node) const {
    const std::string& name = launcher->machine().nodes[static_cast<std::size_t>(node)].name;
    if (job) return srun(1, name);
    return {agent_program(), dir.string(), name};
  }

  /// The node's agent and its guardian are gone. If the node is not, another one can be started.
  void revive(int node) {
    if (const Status started = start(starter_of(node)); !started) log::warning("pilot", started.error().message);
    retries[node] = loop.after(kRetryEvery, [this, node] { revive(node); });
  }

  void is_back(int node) {
    const auto found = retries.find(node);
    if (found == retries.end()) return;
    loop.cancel(found->second);
    retries.erase(found);
  }

  Status await_agents() {
    awaiting = true;
    const std::vector<int> absent = launcher->await_agents(kArrival, kPatience);
    awaiting = false;
    for (const int node : absent) retries[node] = loop.after(kRetryEvery, [this, node] { revive(node); });
    if (absent.size() == launcher->machine().nodes.size())
      return Error{fmt::format("not one agent came from the {} node(s); see what was written above", absent.size()),
                   Exit::internal};
    return {};
  }
};

NodeBlock::NodeBlock(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<NodeBlock>> NodeBlock::of_slurm_job(RealLoop& loop, const fs::path& dir, int cores) {
  GRANARY_TRY(SlurmJob job, current_slurm_job());
  for (Node& node : job.machine.nodes)
    if (cores > 0 && node.cpus.size() > static_cast<std::size_t>(cores))
      node.cpus.resize(static_cast<std::size_t>(cores));
  auto state = std::make_unique<State>(loop, dir);
  GRANARY_CHECK(state->check_program());
  GRANARY_TRY(state->launcher, AgentLauncher::listen(loop, dir, job.machine, job.address));
  state->job = std::move(job);
  GRANARY_CHECK(state->start_steps());
  std::unique_ptr<NodeBlock> block(new NodeBlock(std::move(state)));
  GRANARY_CHECK(block->state_->await_agents());
  return block;
}

Result<std::unique_ptr<NodeBlock>> NodeBlock::of_virtual_nodes(RealLoop& loop, const fs::path& dir, int nodes,
                                                               int cores) {
  auto state = std::make_unique<State>(loop, dir);
  GRANARY_CHECK(state->check_program());
  const Machine machine = stated_machine(nodes, cores);
  GRANARY_TRY(state->launcher, AgentLauncher::listen(loop, dir, machine, "127.0.0.1"));
  std::unique_ptr<NodeBlock> block(new NodeBlock(std::move(state)));
  State& s = *block->state_;
  for (int node = 0; node < nodes; ++node) GRANARY_CHECK(s.start(s.starter_of(node)));
  GRANARY_CHECK(s.await_agents());
  return block;
}

NodeBlock::~NodeBlock() {
  State& state = *state_;
  for (const auto& [node, timer] : state.retries) state.loop.cancel(timer);
  state.launcher.reset();  // the agents' last word
  const double until = state.loop.now() + kFarewell;
  const TimerId limit = state.loop.after(kFarewell, [&state] { state.loop.stop(); });
  std::function<void()> look = [&] {
    if (state.starters.empty() || state.loop.now() > until) return state.loop.stop();
    state.loop.after(0.005, look);
  };
  look();
  if (!state.starters.empty()) state.loop.run();
  state.loop.cancel(limit);
  for (const auto& [fd, pid] : state.starters) {
    state.loop.unwatch(fd);
    ::kill(pid, SIGTERM);
    close(fd);
  }
}

AgentLauncher& NodeBlock::launcher() { return *state_->launcher; }
const Machine& NodeBlock::machine() const { return state_->launcher->machine(); }
std::optional<double> NodeBlock::end_time() const { return state_->job ? state_->job->end_time : std::nullopt; }

void NodeBlock::watch(std::function<void(int, const std::string&)> lost, std::function<void(int)> back) {
  State* state = state_.get();
  state->launcher->watch({std::move(lost),
                          [state, back = std::move(back)](int node) {
                            state->is_back(node);
                            back(node);
                          },
                          [state](int node) { state->revive(node); }});
}

}  // namespace granary::pilot
