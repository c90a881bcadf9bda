#include "controller/bench/estimation_bench.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "common/math/percentile.hpp"
#include "controller/bench/idle_cores.hpp"
#include "controller/bench/stopwatch.hpp"
#include "controller/estimation/estimation_run.hpp"
#include "pilot/launch/local_launcher.hpp"
#include "pilot/launch/run_program.hpp"
#include "pilot/loop/real_loop.hpp"

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using json::Value;

constexpr double kTimeout = 36000.0;  // [s]

using Words = std::vector<std::string>;

Result<Value> run_json(const Words& argv) {
  GRANARY_TRY(const pilot::ProgramOutput ended, pilot::run_program(argv, "", kTimeout));
  if (ended.exit_code != 0)
    return Error{fmt::format("{} ended with exit code {} (signal {}): {}", fmt::join(argv, " "), ended.exit_code,
                             ended.signal, ended.err.substr(0, 2000)),
                 Exit::task_failed};
  return json::parse(ended.out, fmt::format("what {} printed", argv.front()));
}

std::string granary_pbm() { return (program_folder() / "granary-pbm").string(); }

/// How many seeds of a problem a method gets.
int seeds_of(Effort effort, estimation::Method method) {
  if (method == estimation::Method::hybrid) return by_effort(effort, 3, 20, 20);
  return by_effort(effort, 0, 6, 20);
}

/// An estimation alone on the cores of this machine: share of them busy, and evaluations a second.
struct RealRun {
  double core_use = 0.0, wall = 0.0;
  long evaluations = 0;
};

Result<RealRun> run_alone(const estimation::Problem& problem, estimation::Method method, const fs::path& dir,
                          int cores) {
  GRANARY_CHECK(make_folders(dir));
  GRANARY_TRY(const pilot::Machine machine, pilot::local_machine(cores));
  pilot::RealLoop loop;
  pilot::LocalLauncher launcher(loop, machine);
  GRANARY_TRY(pilot::Journal journal, pilot::Journal::open(dir / "journal.jsonl"));
  GRANARY_TRY(const auto pilot, pilot::Pilot::open({dir, machine}, loop, launcher, journal));
  estimating::Crew crew({dir, granary_pbm(), machine.n_cores(), {method, 1, 3000}, true});
  GRANARY_CHECK(crew.begin(problem));
  estimating::EstimationRun run(crew, *pilot, loop);
  GRANARY_CHECK(run.begin());
  loop.run();
  if (run.failure()) return *run.failure();
  const pilot::Usage usage = pilot->usage();
  return RealRun{usage.busy / usage.total, pilot->now(), crew.estimator().evaluated()};
}

/// One row of the twins, with what a run of the same problem by real tasks adds.
Result<Value> row_of(const EstimationBench& bench, estimation::Method method, int n_parameters) {
  const std::string name = estimation::name_of(method), n = std::to_string(n_parameters);
  GRANARY_TRY(const Value twins, run_json({granary_pbm(), "bench", "twins", "--parameters", n, "--method", name,
                                           "--seeds", std::to_string(seeds_of(bench.effort, method))}));
  GRANARY_TRY(const Value twin, run_json({granary_pbm(), "bench", "twins", "--parameters", n, "--write"}));
  GRANARY_TRY(const estimation::Problem problem, estimation::read_problem(twin["problem"], "twin"));
  GRANARY_TRY(const RealRun real, run_alone(problem, method, bench.dir / (name + "-" + n), bench.cores));
  Value row = twins["methods"].items().front();
  return row.set("core_use", real.core_use)
      .set("real_wall_s", real.wall)
      .set("real_evaluations", std::int64_t{real.evaluations});
}

/// From the start of granary-pbm evaluate to its first evaluation: it is given none, and ends [s].
Result<double> evaluator_start_up(const fs::path& dir) {
  GRANARY_TRY(const Value twin, run_json({granary_pbm(), "bench", "twins", "--parameters", "2", "--write"}));
  const fs::path problem = dir / "problem.json", trials = dir / "trials.json", out = dir / "out.jsonl";
  GRANARY_CHECK(json::write_file(problem, twin["problem"]));
  GRANARY_CHECK(json::write_file(trials, Value::object({{"trials", Value::array()}})));
  std::vector<double> seconds;
  for (int k = 0; k < 9; ++k) {
    const auto began = Clock::now();
    GRANARY_TRY(const pilot::ProgramOutput ended, pilot::run_program({granary_pbm(), "evaluate", problem.string(),
                                                                      trials.string(), "--out", out.string()},
                                                                     "", kTimeout));
    if (ended.exit_code != 0) return Error{"granary-pbm evaluate: " + ended.err, Exit::task_failed};
    seconds.push_back(seconds_since(began));
  }
  return median(seconds);
}

/// The workflow without its estimation, and with it but without the final run that would follow.
Result<Value> coupled(const EstimationBench& bench, const std::function<void(const std::string&)>& say) {
  GRANARY_TRY(Value document, json::read_file(bench.workflow));
  std::erase_if(document.members(), [](const json::Member& m) { return m.first == "estimation"; });
  const fs::path without = bench.dir / "off.json";
  GRANARY_CHECK(json::write_file(without, document));
  const std::string granary = (program_folder() / "granary").string();
  const int rounds = by_effort(bench.effort, 1, 1, 3);
  std::vector<Value> on, off;
  std::vector<IdleCores> idle;
  for (int k = 0; k < rounds; ++k) {
    say(fmt::format("{} off and on, {} of {}", bench.workflow.filename().string(), k + 1, rounds));
    GRANARY_TRY(Value one, run_json({granary, "run", without.string(), "--dir",
                                     (bench.dir / fmt::format("off-{}", k)).string(), "--json", "--quiet"}));
    off.push_back(std::move(one));
    const fs::path dir = bench.dir / fmt::format("on-{}", k);
    GRANARY_TRY(Value other, run_json({granary, "run", bench.workflow.string(), "--dir", dir.string(), "--json",
                                       "--quiet", "--set", "/estimation/adopt=\"never\""}));
    on.push_back(std::move(other));
    GRANARY_TRY(IdleCores seen, idle_cores_of(dir / "journal.jsonl"));
    idle.push_back(std::move(seen));
  }
  const auto least = [](const std::vector<Value>& runs) {
    return *std::min_element(runs.begin(), runs.end(), [](const Value& a, const Value& b) {
      return a["wall_s"].as_number() < b["wall_s"].as_number();
    });
  };
  const Value best_on = least(on), best_off = least(off);
  GRANARY_TRY(const double start_up, evaluator_start_up(bench.dir));
  Value seen = to_json(idle);
  return seen.set("evaluator_start_up_ms", 1e3 * start_up)
      .set("workflow", bench.workflow.string())
      .set("rounds", rounds)
      .set("on_s", best_on["wall_s"])
      .set("off_s", best_off["wall_s"])
      .set("slowdown", best_on["wall_s"].as_number() / best_off["wall_s"].as_number() - 1.0)
      .set("core_use_on", best_on["core_use"])
      .set("core_use_off", best_off["core_use"]);
}

}  // namespace

Result<Value> run_estimation_bench(const EstimationBench& bench, const std::function<void(const std::string&)>& say) {
  Value methods = Value::array(), document = Value::object();
  const std::vector<int> sizes = bench.effort == Effort::quick ? std::vector<int>{2} : std::vector<int>{2, 4, 6};
  for (const int n : sizes)
    for (const estimation::Method method : estimation::kMethods) {
      if (seeds_of(bench.effort, method) == 0) continue;
      say(fmt::format("twins of {} parameters, {}", n, estimation::name_of(method)));
      GRANARY_TRY(Value row, row_of(bench, method, n));
      methods.push(std::move(row));
    }
  say("rate and efficiency, of which only the product can be found");
  GRANARY_TRY(const Value product, run_json({granary_pbm(), "bench", "twins", "--product", "--seeds",
                                             std::to_string(by_effort(bench.effort, 2, 20, 20))}));
  document.set("effort", std::string(name_of(bench.effort))).set("methods", methods);
  document.set("product", product["product"]);
  if (bench.workflow.empty())
    return document.set("coupled_slowdown", Value())
        .set("core_use_on", Value())
        .set("core_use_off", Value())
        .set("coupled_why", "no --workflow was given");
  GRANARY_TRY(const Value runs, coupled(bench, say));
  return document.set("coupled_slowdown", runs["slowdown"])
      .set("core_use_on", runs["core_use_on"])
      .set("core_use_off", runs["core_use_off"])
      .set("coupled", runs);
}

std::string estimation_table(const Value& document) {
  std::string text =
      "| method | parameters | seeds | in the 95 % interval | as good as the truth | evaluations, median "
      "(most) | with intervals | core use |\n|---|---|---|---|---|---|---|---|\n";
  for (const Value& row : document["methods"].items())
    text += fmt::format("| {} | {} | {} | {:.1f} % | {:.0f} % | {:.0f} ({:.0f}) | {:.0f} | {:.0f} % |\n",
                        row["name"].as_string(), row["parameters"].as_integer(), row["seeds"].as_integer(),
                        100.0 * row["recovered_share"].as_number(), 100.0 * row["found_share"].as_number(),
                        row["evaluations_median"].as_number(), row["evaluations_most"].as_number(),
                        row["with_intervals_median"].as_number(), 100.0 * row["core_use"].as_number());
  const Value& product = document["product"];
  text += fmt::format("\nProduct: {:.0f} % of {} seeds warned: \"{}\"\n", 100.0 * product["warned_share"].as_number(),
                      product["seeds"].as_integer(), product["warning"].as_string());
  if (document["coupled_slowdown"].is_null()) return text;
  text +=
      fmt::format("\nCoupled campaign with estimation: {:+.1f} % of its time; core use {:.0f} % instead of {:.0f} %\n",
                  100.0 * document["coupled_slowdown"].as_number(), 100.0 * document["core_use_on"].as_number(),
                  100.0 * document["core_use_off"].as_number());
  const Value& coupled = document["coupled"];
  text += "\n| [ms] | median | 99 % | most | times |\n|---|---|---|---|---|\n";
  for (const auto& [key, what] :
       {std::pair{"put_to_work_ms", "a core falls idle -> an evaluation's process has begun there"},
        {"given_back_ms", "a filler is told to give way -> the burst's program has begun"}})
    text += fmt::format("| {} | {:.1f} | {:.1f} | {:.1f} | {} |\n", what, coupled[key]["p50"].as_number(),
                        coupled[key]["p99"].as_number(), coupled[key]["most"].as_number(),
                        coupled[key]["times"].as_integer());
  const Value& idle = coupled["idle_core_s"];
  text += fmt::format(
      "\nthe process evaluates {:.0f} ms after its begin. Core seconds idle, of {} campaigns: {:.2f} before the "
      "first rates, {:.2f} at switches, {:.2f} after the last on a core\n",
      coupled["evaluator_start_up_ms"].as_number(), coupled["rounds"].as_integer(), idle["before_rates"].as_number(),
      idle["at_switches"].as_number(), idle["afterwards"].as_number());
  return text;
}

}  // namespace granary::bench
