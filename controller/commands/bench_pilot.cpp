#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <vector>

#include "common/json/io.hpp"
#include "controller/bench/pilot_local.hpp"
#include "controller/bench/pilot_simulation.hpp"
#include "controller/bench/pilot_slurm.hpp"
#include "controller/bench/pilot_table.hpp"
#include "controller/bench/scratch_folder.hpp"
#include "controller/commands/commands.hpp"

namespace granary::commands {
namespace fs = std::filesystem;
using json::Value;

namespace {

Value as_json(const bench::SimulationRun& run) {
  return Value::object({{"nodes", run.size.nodes},
                        {"cores", run.size.cores},
                        {"tasks", run.size.tasks},
                        {"finished", run.finished},
                        {"submit_s", run.submit_s},
                        {"run_s", run.run_s},
                        {"cpu_s", run.cpu_s},
                        {"placements_per_s", run.placements_per_s()},
                        {"placements_per_cpu_s", run.finished / run.cpu_s},
                        {"cost_per_task_s", run.cost_per_task()},
                        {"bytes_per_task", run.bytes_per_task},
                        {"journal_bytes_per_task", run.journal_bytes / run.size.tasks},
                        {"makespan_s", run.makespan},
                        {"lower_bound_s", run.lower_bound},
                        {"core_use", run.core_use}});
}

/// Of the largest size, with all the others behind it.
Value summary_of(Value rows, double cost_growth) {
  const Value& last = rows.items().back();
  Value document = Value::object({{"placements_per_s", last["placements_per_s"]},
                                  {"placements_per_cpu_s", last["placements_per_cpu_s"]},
                                  {"bytes_per_task", last["bytes_per_task"]},
                                  {"core_use", last["core_use"]},
                                  {"lower_bound", last["lower_bound_s"]},
                                  {"makespan", last["makespan_s"]},
                                  {"cost_growth", cost_growth}});
  document.set("scaling", std::move(rows));
  return document;
}

/// The asked size, and before it smaller ones of the same shape: tasks and nodes ten times fewer each.
Result<Value> simulate(const bench::SimulationSize& size, const fs::path& dir,
                       const std::function<void(const std::string&)>& say) {
  std::vector<bench::SimulationSize> sizes{size};
  while (sizes.back().tasks >= 10'000)
    sizes.push_back({std::max(1, sizes.back().nodes / 10), size.cores, sizes.back().tasks / 10});
  Value rows = Value::array();
  double cheapest = 0.0, dearest = 0.0;
  for (auto each = sizes.rbegin(); each != sizes.rend(); ++each) {
    say(fmt::format("simulate {} tasks on {} nodes x {} cores", each->tasks, each->nodes, each->cores));
    GRANARY_TRY(const bench::SimulationRun run, bench::simulate_pilot_steadily(*each, dir));
    rows.push(as_json(run));
    const double cost = run.cost_per_task();
    cheapest = cheapest == 0.0 ? cost : std::min(cheapest, cost);
    dearest = std::max(dearest, cost);
  }
  return summary_of(std::move(rows), dearest / cheapest);
}

}  // namespace

Result<Exit> bench_pilot(const PilotBenchOptions& options) {
  const auto began = std::chrono::steady_clock::now();
  const auto say = [began](const std::string& what) {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    fmt::print(stderr, "bench pilot: {:6.1f} s  {}\n", seconds, what);
  };
  bench::SimulationSize size{10'000, 64, options.quick ? 10'000 : 1'000'000};
  if (!options.simulate.empty()) {
    GRANARY_TRY(size, bench::parse_simulation_size(options.simulate));
  }
  const fs::path below = options.dir.empty() ? fs::temp_directory_path() : options.dir;
  const auto scratch = bench::ScratchFolder::make(below);
  if (!scratch)
    return Error{fmt::format("{}: no folder can be made here for the bench. Give another one: --dir.", below.string())};
  Value document = Value::object();
  if (options.simulate.empty() && !options.slurm) {
    bench::LocalBench local{scratch->path(), options.cores};
    if (options.quick) {
      local.tasks = 1000;
      local.seconds = 1.0;
    }
    GRANARY_TRY(document, bench::run_local_pilot_bench(local, say));
  }
  if (options.slurm || (options.simulate.empty() && bench::in_slurm_job())) {
    std::error_code error;
    fs::create_directory(scratch->path() / "slurm", error);
    GRANARY_TRY(Value slurm, bench::run_slurm_pilot_bench({scratch->path() / "slurm"}, say));
    document.set("slurm", std::move(slurm));
  } else if (options.simulate.empty()) {
    document.set("slurm", Value()).set("slurm_why", "measured inside a job of Slurm only: docs/slurm.md");
  }
  if (options.slurm) {
    fmt::print("{}\n", json::dump(document, 1));
    return Exit::ok;
  }
  GRANARY_TRY(Value simulated, simulate(size, scratch->path(), say));
  document.set("simulate", std::move(simulated));
  say("done");
  fmt::print("{}\n", options.json ? json::dump(document, 1) : bench::pilot_table(document));
  return Exit::ok;
}

}  // namespace granary::commands
