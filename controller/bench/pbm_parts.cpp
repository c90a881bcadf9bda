#include "controller/bench/pbm_parts.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "common/version.hpp"
#include "pilot/launch/command.hpp"
#include "pilot/launch/run_program.hpp"
#include "pilot/schedule/machine.hpp"

extern char** environ;

namespace granary::bench {
namespace {

namespace fs = std::filesystem;
using json::Value;

constexpr const char* kHow =
    "wall time per right-hand side, 10th percentile over the samples (a shared machine disturbs the rest), least of "
    "the "
    "rounds; in_run: the steps of a real run, rhs_alone: right-hand sides one after the other";

std::string program() { return (program_folder() / "granary-pbm").string(); }

double timeout_of(Effort effort) {
  return effort == Effort::quick ? 300.0 : effort == Effort::usual ? 1800.0 : 36000.0;
}

Result<Value> run_json(const std::vector<std::string>& argv, double timeout_s) {
  GRANARY_TRY(const pilot::ProgramOutput ended, pilot::run_program(argv, "", timeout_s));
  if (ended.exit_code != 0)
    return Error{fmt::format("{} ended with exit code {} (signal {}): {}", fmt::join(argv, " "), ended.exit_code,
                             ended.signal, ended.err.substr(0, 2000)),
                 Exit::task_failed};
  return json::parse(ended.out, fmt::format("what {} bench printed", argv.front()));
}

/// What the row bench said, round by round, of one and of two workers.
struct Pair {
  std::array<std::vector<Value>, 2> rounds;
  double least(std::size_t workers, const char* what) const {
    double least = 1e300;
    for (const Value& round : rounds[workers - 1]) least = std::min(least, round[what].number_or("p10_s", 1e300));
    return least;
  }
  double efficiency(const char* what) const { return least(1, what) / (2.0 * least(2, what)); }
  Value json() const {
    Value all = Value::object({{"how", kHow}, {"grid", "16x16x16"}, {"classes", 8}, {"rounds", rounds[0].size()}});
    for (const char* what : {"in_run", "rhs_alone"})
      all.set(what,
              Value::object({{"one_s", least(1, what)}, {"two_s", least(2, what)}, {"efficiency", efficiency(what)}}));
    return all;
  }
};

/// One and two workers in turn, so that a busy spell of the machine meets both.
Result<Pair> in_turn(Effort effort, const std::function<Result<Value>(int workers, double seconds)>& run) {
  const int rounds = effort == Effort::quick ? 1 : 3;
  const double seconds = effort == Effort::quick ? 0.5 : 1.0;
  Pair pair;
  for (int round = 0; round < rounds; ++round)
    for (const int workers : {1, 2}) {
      GRANARY_TRY(Value one, run(workers, seconds));
      pair.rounds[static_cast<std::size_t>(workers - 1)].push_back(std::move(one));
    }
  return pair;
}

std::vector<std::string> row_command(int threads, double seconds) {
  return {program(), "bench", "row", "--threads", std::to_string(threads), "--seconds", fmt::format("{:g}", seconds)};
}

/// As the pilot starts threads: each on a core of its own.
Result<Pair> time_threads(Effort effort) {
  return in_turn(effort, [effort](int threads, double seconds) {
    std::vector<std::string> argv{"env", "OMP_PLACES=cores", "OMP_PROC_BIND=close"};
    const auto command = row_command(threads, seconds);
    argv.insert(argv.end(), command.begin(), command.end());
    return run_json(argv, timeout_of(effort));
  });
}

/// As the pilot starts ranks: mpirun with a rank file, each rank on a core of its own.
Result<Pair> time_ranks(Effort effort, const pilot::Machine& machine) {
  std::vector<std::string> env;
  for (char** entry = environ; *entry != nullptr; ++entry) env.emplace_back(*entry);
  const fs::path rank_file = fs::temp_directory_path() / fmt::format("granary-bench-{}.ranks", getpid());
  auto pair = in_turn(effort, [&](int ranks, double seconds) -> Result<Value> {
    pilot::Launch launch;
    launch.spec.command = row_command(1, seconds);
    launch.spec.ranks = ranks;
    launch.spec.mpi = true;
    launch.cores.add(0, ranks);
    GRANARY_CHECK(write_text_atomically(rank_file, pilot::rank_file_text(launch, machine)));
    GRANARY_TRY(Value timed, run_json(pilot::mpirun_argv(launch, env, rank_file, geteuid() == 0), timeout_of(effort)));
    if (timed.integer_or("ranks", 0) != ranks)
      return Error{fmt::format("mpirun started {} ranks, but granary-pbm saw {}: was it built with MPI?", ranks,
                               timed.integer_or("ranks", 0)),
                   Exit::task_failed};
    return timed;
  });
  std::error_code ignored;
  fs::remove(rank_file, ignored);
  return pair;
}

/// Sets NAME_efficiency, with NAME_efficiency_rhs_alone and the figures behind them; or null, and why.
void add_efficiency(Value& document, const std::string& name, const Result<Pair>& pair) {
  if (!pair) {
    document.set(name + "_efficiency", Value()).set(name + "_efficiency_why", pair.error().message);
    return;
  }
  document.set(name + "_efficiency", pair->efficiency("in_run"))
      .set(name + "_efficiency_rhs_alone", pair->efficiency("rhs_alone"))
      .set(name + "_timings", pair->json());
}

Status add_part(Value& document, const char* part, Effort effort) {
  std::vector<std::string> argv{program(), "bench", part};
  if (effort != Effort::usual) argv.emplace_back(effort == Effort::quick ? "--quick" : "--full");
  GRANARY_TRY(const Value result, run_json(argv, timeout_of(effort)));
  for (const auto& [key, value] : result.members_or_none()) document.set(key, value);
  return {};
}

}  // namespace

Result<Value> run_pbm_bench(Effort effort, const std::function<void(const std::string&)>& say) {
  GRANARY_TRY(const pilot::Machine machine, pilot::local_machine());
  Value document = Value::object({{"bench", "pbm"},
                                  {"version", std::string(version())},
                                  {"revision", std::string(revision())},
                                  {"effort", effort == Effort::quick   ? "quick"
                                             : effort == Effort::usual ? "usual"
                                                                       : "full"},
                                  {"cores", machine.n_cores()}});
  say("right-hand sides, the solver and the plain reference");
  GRANARY_CHECK(add_part(document, "rhs", effort));
  say("error against CPU time, the solver and the plain reference");
  GRANARY_CHECK(add_part(document, "work-precision", effort));
  say("errors of the time integration");
  GRANARY_CHECK(add_part(document, "temporal", effort));
  say("the published case");
  GRANARY_CHECK(add_part(document, "published", effort));
  const Error one_core{"there is one core only", Exit::ok};
  const bool two = machine.largest_node() >= 2;
  say("one thread and two");
  add_efficiency(document, "threads", two ? time_threads(effort) : Result<Pair>(one_core));
  say("one rank and two");
  add_efficiency(document, "ranks", two ? time_ranks(effort, machine) : Result<Pair>(one_core));
  return document;
}

}  // namespace granary::bench
