#include "controller/bench/pilot_slurm.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <optional>

#include "controller/bench/stopwatch.hpp"
#include "pilot/agent/node_block.hpp"
#include "pilot/launch/command.hpp"
#include "pilot/launch/spawn.hpp"
#include "pilot/task_list.hpp"

extern char** environ;

namespace granary::bench {
namespace {

std::vector<pilot::TaskSpec> tasks_of_true(int count) {
  std::vector<pilot::TaskSpec> tasks(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    tasks[static_cast<std::size_t>(k)].name = fmt::format("t{}", k);
    tasks[static_cast<std::size_t>(k)].command = {"/bin/true"};
  }
  return tasks;
}

struct AgentFigures {
  double per_s = 0.0, start_s = 0.0;
  pilot::Machine machine;
};

Result<AgentFigures> through_agents(const SlurmBench& bench) {
  const auto began = Clock::now();
  AgentFigures figures;
  GRANARY_TRY(pilot::Journal journal, pilot::Journal::open(bench.dir / "journal.jsonl"));
  pilot::RealLoop loop;
  const int nodes = std::max(1, std::atoi(std::getenv("SLURM_JOB_NUM_NODES")));
  GRANARY_TRY(const auto block, pilot::NodeBlock::of_slurm_job(loop, bench.dir, (bench.in_flight + nodes - 1) / nodes));
  figures.machine = block->machine();
  GRANARY_TRY(const auto pilot, pilot::Pilot::open({bench.dir, figures.machine}, loop, block->launcher(), journal));
  block->watch([&](int node, const std::string& why) { pilot->lose_node(node, why); },
               [&](int node) { pilot->regain_node(node); });
  std::optional<double> first;
  pilot->on_end([&](const pilot::TaskEnd&) {
    if (!first) first = seconds_since(began);
  });
  const auto submitted = Clock::now();
  GRANARY_TRY(const auto summary, pilot::run_task_list(tasks_of_true(bench.tasks), *pilot, loop));
  if (summary.finished != bench.tasks)
    return Error{fmt::format("{} of {} tasks failed", bench.tasks - summary.finished, bench.tasks), Exit::task_failed};
  figures.per_s = bench.tasks / seconds_since(submitted);
  figures.start_s = first.value_or(0.0);
  return figures;
}

/// Steps one after the other, so many at once; each names its node, as a pilot that places tasks must.
class Steps {
 public:
  Steps(const pilot::Machine& machine, int in_flight, int count)
      : machine_(machine), in_flight_(in_flight), to_start_(count) {
    for (char** entry = environ; *entry != nullptr; ++entry) request_.env.emplace_back(*entry);
  }

  /// Steps a second.
  Result<double> run(int count) {
    GRANARY_TRY(request_.file, pilot::find_executable("srun", "", std::getenv("PATH")));
    const auto began = Clock::now();
    for (int k = 0; k < in_flight_; ++k) GRANARY_CHECK(start_next());
    loop_.run();
    if (failed_ > 0) return Error{fmt::format("{} of {} steps failed", failed_, count), Exit::task_failed};
    return count / seconds_since(began);
  }

 private:
  Status start_next() {
    if (to_start_ == 0) return {};
    const std::string& node = machine_.nodes[static_cast<std::size_t>(--to_start_) % machine_.nodes.size()].name;
    request_.argv = {"srun", "--exact", "-N1", "-n1", "-c1", "--mem=0", "--input=none", "-w", node, "/bin/true"};
    GRANARY_TRY(const pilot::Spawned process, pilot::spawn(request_));
    loop_.watch(process.pidfd, [this, fd = process.pidfd] {
      loop_.unwatch(fd);
      failed_ += pilot::reap(fd).exit_code != 0;
      close(fd);
      if (!start_next()) ++failed_;
    });
    return {};
  }

  const pilot::Machine& machine_;
  int in_flight_, to_start_, failed_ = 0;
  pilot::SpawnRequest request_;
  pilot::RealLoop loop_;
};

}  // namespace

bool in_slurm_job() { return std::getenv("SLURM_JOB_ID") != nullptr && std::getenv("SLURM_JOB_NUM_NODES") != nullptr; }

Result<json::Value> run_slurm_pilot_bench(const SlurmBench& bench, const std::function<void(const std::string&)>& say) {
  if (!in_slurm_job()) return Error{"the bench of agents runs inside a job of Slurm: salloc or sbatch."};
  say(fmt::format("{} tasks through agents, {} at once", bench.tasks, bench.in_flight));
  GRANARY_TRY(const AgentFigures agents, through_agents(bench));
  say(fmt::format("{} steps through srun, {} at once", bench.steps, bench.in_flight));
  Steps steps(agents.machine, bench.in_flight, bench.steps);
  GRANARY_TRY(const double srun_per_s, steps.run(bench.steps));
  return json::Value::object({{"agent_per_s", agents.per_s},
                              {"srun_per_s", srun_per_s},
                              {"ratio", agents.per_s / srun_per_s},
                              {"start_s", agents.start_s},
                              {"nodes", agents.machine.nodes.size()},
                              {"in_flight", bench.in_flight}});
}

}  // namespace granary::bench
