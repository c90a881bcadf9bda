// granary-pbm: one population balance, case in, HDF5 out.
#include <omp.h>
#include <sched.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/json/io.hpp"
#include "common/log.hpp"
#include "common/version.hpp"
#include "pbm_solver/bench/bench_command.hpp"
#include "pbm_solver/evaluate/evaluate_command.hpp"
#include "pbm_solver/parallel/communicator.hpp"
#include "pbm_solver/run.hpp"
#include "pbm_solver/verification/verify_command.hpp"

namespace {

namespace pbm = granary::pbm;
using granary::json::Value;

constexpr const char* kExamples = R"(Examples:
  granary-pbm run case.json --out out.h5                      one rank, one thread
  granary-pbm run case.json --out out.h5 --threads 4 --json   the report as one JSON document on stdout
  mpirun -np 4 granary-pbm run case.json --out out.h5         compartments shared by 4 ranks
  granary-pbm verify                                          every exact solution, with its error
  granary-pbm verify sum-2d --bins 32

progress.jsonl and checkpoint.h5 are written beside the --out file; SIGTERM or SIGUSR1 end a run after its
step with a checkpoint. To go on, name out.h5 or checkpoint.h5 in the case: "restart": {"file": "out.h5"}.
Exit: 0 done or stopped, 2 bad input, 20 the tolerance cannot be kept.)";

int default_threads() {
  const char* asked = std::getenv("OMP_NUM_THREADS");
  const int threads = asked != nullptr ? std::atoi(asked) : 1;
  return threads > 0 ? threads : 1;
}

/// With OMP_PROC_BIND, OpenMP has pinned this thread to its first place before main() begins; a program started from
/// here would see that one core only, and put all its threads on it.
void give_back_all_cores() {
  cpu_set_t all;
  CPU_ZERO(&all);
  for (int place = 0; place < omp_get_num_places(); ++place) {
    std::vector<int> cores(static_cast<std::size_t>(omp_get_place_num_procs(place)));
    omp_get_place_proc_ids(place, cores.data());
    for (const int core : cores) CPU_SET(core, &all);
  }
  if (CPU_COUNT(&all) > 0) sched_setaffinity(0, sizeof all, &all);
}

/// OpenMP's threads wait by spinning, and read how long before main() begins. On a busy machine they then burn the time
/// that the others need: ten times slower was measured. So start over with a short spin, unless the user has said
/// something.
void start_over_with_polite_threads(int threads, char** argv) {
  if (threads < 2 || std::getenv("GOMP_SPINCOUNT") != nullptr || std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  setenv("GOMP_SPINCOUNT", "2000", 1);
  give_back_all_cores();
  execv("/proc/self/exe", argv);  // comes back only if it could not: then go on as we are
}

int fail(const granary::Error& error, bool loud) {
  if (loud) std::fprintf(stderr, "granary-pbm: %s\n", error.message.c_str());
  return static_cast<int>(error.exit);
}

int run(const pbm::RunOptions& options, bool as_json) {
  const pbm::Communicator ranks;
  pbm::install_stop_signals();
  const auto report = pbm::run_case(options, ranks);
  if (!report) return fail(report.error(), ranks.first());
  if (!ranks.first()) return 0;
  if (as_json) {
    std::printf("%s\n", granary::json::dump(*report, 2).c_str());
  } else {
    const Value& r = *report;
    std::printf("%s at %g s: %lld steps (%lld rejected), %g s of wall time; states in %s\n",
                r["ended"].as_string().c_str(), r["time_s"].as_number(),
                static_cast<long long>(r["steps"].as_integer()), static_cast<long long>(r["rejected"].as_integer()),
                r["wall_s"].as_number(), r["out"].as_string().c_str());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"granary-pbm: one population balance of granules, case in, HDF5 out"};
  app.footer(kExamples);
  app.set_version_flag("--version", std::string(granary::version()) + " " + std::string(granary::revision()));
  app.require_subcommand(1);
  bool as_json = false;

  CLI::App* run_command = app.add_subcommand("run", "run one case (docs/exchange_formats.md)");
  run_command->footer(kExamples);
  pbm::RunOptions options;
  options.threads = default_threads();
  run_command->add_option("CASE", options.case_file, "the case, a JSON file")->required();
  run_command->add_option("--out", options.out, "the HDF5 file to write")->required();
  run_command->add_option("--threads", options.threads, "threads of each rank")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  run_command->add_flag("--json", as_json, "report as one JSON document");

  pbm::EvaluateOptions evaluation;
  const CLI::App* evaluate_command = pbm::add_evaluate_command(app, evaluation);
  pbm::VerifyOptions verification;
  const CLI::App* verify_command = pbm::add_verify_command(app, verification);
  pbm::BenchOptions bench;
  const CLI::App* bench_command = pbm::add_bench_command(app, bench);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& wrong) {
    return app.exit(wrong) == 0 ? 0 : static_cast<int>(granary::Exit::bad_input);
  }
  if (evaluate_command->parsed()) {
    const auto evaluated = pbm::evaluate(evaluation);
    return evaluated ? 0 : fail(evaluated.error(), true);
  }
  if (verify_command->parsed()) return pbm::run_verify_command(verification);
  start_over_with_polite_threads(bench_command->parsed() ? bench.threads : options.threads, argv);
  if (bench_command->parsed()) return pbm::run_bench_command(bench);
  return run(options, as_json);
}
