#include "pbm_solver/verification/verify_command.hpp"

#include <cstdio>
#include <vector>

#include "common/json/io.hpp"
#include "pbm_solver/verification/verification.hpp"

namespace granary::pbm {
namespace {

using json::Value;

void print_row(const Verification& v) {
  std::printf("%-12s %5d  %9.2e %9.2e  %+9.1e %+9.1e %+9.1e  %8.1e  %6ld %7ld %8.3f  %s\n", v.name.c_str(), v.bins,
              v.l1_number, v.l1_volume, v.moment_0, v.moment_1, v.moment_2, v.drift, v.steps, v.rhs_evaluations, v.cpu,
              v.best_known ? json::dump(*v.best_known).c_str() : "");
}

}  // namespace

CLI::App* add_verify_command(CLI::App& app, VerifyOptions& options) {
  CLI::App* command = app.add_subcommand("verify", "solve cases with exact solutions and show the errors");
  command->add_option("CASE", options.name, "constant-1d, sum-1d, constant-2d, sum-2d, breakage or all")
      ->capture_default_str();
  command->add_option("--bins", options.bins, "classes along each solid");
  command->add_option("--tolerance", options.tolerance, "relative tolerance of the time steps")
      ->check(CLI::Range(1e-12, 0.1))
      ->capture_default_str();
  command->add_flag("--json", options.as_json, "one JSON document");
  return command;
}

/// Errors against exact solutions. Whether they are small enough is for the tests to say; here they are shown.
int run_verify_command(const VerifyOptions& options) {
  Value all = Value::array();
  if (!options.as_json)
    std::printf("%-12s %5s  %9s %9s  %9s %9s %9s  %8s  %6s %7s %8s  %s\n", "case", "bins", "L1 number", "L1 volume",
                "M0", "M1", "M2", "drift", "steps", "rhs", "cpu [s]", "plain cell average, L1 number");
  for (const std::string& one : options.name == "all" ? verification_names() : std::vector<std::string>{options.name}) {
    const auto result = verify(one, options.bins, options.tolerance);
    if (!result) {
      std::fprintf(stderr, "granary-pbm: %s\n", result.error().message.c_str());
      return static_cast<int>(result.error().exit);
    }
    if (!options.as_json) print_row(*result);
    all.push(to_json(*result));
  }
  if (options.as_json) std::printf("%s\n", json::dump(all, 2).c_str());
  return 0;
}

}  // namespace granary::pbm
