// granary-pbm: one population balance, case in, HDF5 out.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "common/json/io.hpp"
#include "common/log.hpp"
#include "common/version.hpp"
#include "pbm_solver/parallel/communicator.hpp"
#include "pbm_solver/run.hpp"
#include "pbm_solver/verification/verification.hpp"

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

/// OpenMP's threads wait by spinning, and read how long before main() begins. On a busy machine they then burn the time
/// that the others need: ten times slower was measured. So start over with a short spin, unless the user has said
/// something.
void start_over_with_polite_threads(int threads, char** argv) {
  if (threads < 2 || std::getenv("GOMP_SPINCOUNT") != nullptr || std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  setenv("GOMP_SPINCOUNT", "2000", 1);
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

void print_row(const pbm::Verification& v) {
  std::printf("%-12s %5d  %9.2e %9.2e  %+9.1e %+9.1e %+9.1e  %8.1e  %6ld %7ld %8.3f  %s\n", v.name.c_str(), v.bins,
              v.l1_number, v.l1_volume, v.moment_0, v.moment_1, v.moment_2, v.drift, v.steps, v.rhs_evaluations, v.cpu,
              v.best_known ? granary::json::dump(*v.best_known).c_str() : "");
}

/// Errors against exact solutions. Whether they are small enough is for the tests to say; here they are shown.
int verify(const std::string& name, std::optional<int> bins, double tolerance, bool as_json) {
  Value all = Value::array();
  if (!as_json)
    std::printf("%-12s %5s  %9s %9s  %9s %9s %9s  %8s  %6s %7s %8s  %s\n", "case", "bins", "L1 number", "L1 volume",
                "M0", "M1", "M2", "drift", "steps", "rhs", "cpu [s]", "plain cell average, L1 number");
  for (const std::string& one : name == "all" ? pbm::verification_names() : std::vector<std::string>{name}) {
    const auto result = pbm::verify(one, bins, tolerance);
    if (!result) return fail(result.error(), true);
    if (!as_json) print_row(*result);
    all.push(pbm::to_json(*result));
  }
  if (as_json) std::printf("%s\n", granary::json::dump(all, 2).c_str());
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

  CLI::App* verify_command = app.add_subcommand("verify", "solve cases with exact solutions and show the errors");
  std::string name = "all";
  std::optional<int> bins;
  double tolerance = 1e-5;
  verify_command->add_option("CASE", name, "constant-1d, sum-1d, constant-2d, sum-2d, breakage or all")
      ->capture_default_str();
  verify_command->add_option("--bins", bins, "classes along each solid");
  verify_command->add_option("--tolerance", tolerance, "relative tolerance of the time steps")
      ->check(CLI::Range(1e-12, 0.1))
      ->capture_default_str();
  verify_command->add_flag("--json", as_json, "one JSON document");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& wrong) {
    return app.exit(wrong) == 0 ? 0 : static_cast<int>(granary::Exit::bad_input);
  }
  if (verify_command->parsed()) return verify(name, bins, tolerance, as_json);
  start_over_with_polite_threads(options.threads, argv);
  return run(options, as_json);
}
