#include "pbm_solver/verification/verify_command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "common/json/io.hpp"
#include "pbm_solver/verification/convergence_plot.hpp"
#include "pbm_solver/verification/hard_cases.hpp"
#include "pbm_solver/verification/verification.hpp"

namespace granary::pbm {
namespace {

using json::Value;

constexpr const char* kExamples = R"(Examples:
  granary-pbm verify                              every exact solution, on three grids or more
  granary-pbm verify sum-2d                       one of them
  granary-pbm verify sum-2d --bins 64             on another grid (no bounds there, but for what is conserved)
  granary-pbm verify --json > errors.json
  granary-pbm verify --plot convergence.svg       errors against classes
  granary-pbm verify hard                         the cases that break solvers; hard:NAME for one of them
The cases, their bounds and the reasons of these: docs/verification.md.
Exit: 0 all within their bounds, 2 bad input, 3 an error beyond its bound.)";

int fail(const Error& error) {
  std::fprintf(stderr, "granary-pbm: %s\n", error.message.c_str());
  return static_cast<int>(error.exit);
}

std::string or_dash(const char* format, double value) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

constexpr double kNoDrift = 1e-30;  // two digits of exponent are enough
constexpr const char* kRow = "{:<18}{:>5}{:>9}{:>8}{:>7}{:>9}{:>8}{:>8}{:>8}{:>7}{:>8}  {}\n";

void print_heading() {
  fmt::print(
      "Errors of the number by class (L1) and of the second moment (M20), each with its bound, in %; of the total "
      "number (M00);\norder of L1 since the grid before; drift of what is conserved; evaluations; time.\n\n");
  fmt::print(kRow, "case", "bins", "L1", "bound", "order", "M20", "bound", "M00", "drift", "rhs", "cpu s", "ok");
}

void print_row(const Verification& v) {
  fmt::print(kRow, v.name, v.bins, or_dash("{:.3f}", 100.0 * v.errors.l1_number), or_dash("{:.4g}", 100.0 * v.l1_bound),
             or_dash("{:.2f}", v.order), or_dash("{:+.2f}", 100.0 * v.moment("M20")),
             or_dash("{:.4g}", 100.0 * v.moment_bound("M20")), or_dash("{:+.0e}", v.moment("M00")),
             fmt::format("{:.0e}", v.largest_drift() < kNoDrift ? 0.0 : v.largest_drift()), v.rhs_evaluations,
             fmt::format("{:.3f}", v.cpu), v.passed ? "yes" : "NO");
  for (const std::string& fault : v.faults()) fmt::print("{:>23}  {}\n", "", fault);
}

/// Runs the cases one by one; the table grows as they end.
Result<std::vector<Verification>> run_cases(const VerifyOptions& options) {
  std::vector<Verification> all;
  if (!options.as_json) print_heading();
  for (const std::string& name : options.name == "all" ? verification_names() : std::vector{options.name}) {
    GRANARY_TRY(const std::vector<Verification> results, verify_grids(name, options.bins, options.tolerance));
    for (const Verification& v : results) {
      if (!options.as_json && (all.empty() || v.group != all.back().group)) fmt::print("\n{}\n", v.group);
      if (!options.as_json) print_row(v);
      all.push_back(v);
    }
    std::fflush(stdout);
  }
  return all;
}

/// The exact solutions.
int verify_exact(const VerifyOptions& options) {
  const auto results = run_cases(options);
  if (!results) return fail(results.error());
  bool passed = true;
  Value cases = Value::array();
  for (const Verification& v : *results) {
    passed = passed && v.passed;
    cases.push(to_json(v));
  }
  if (options.as_json) std::printf("%s\n", json::dump(Value::object({{"cases", cases}}), 2).c_str());
  if (!options.plot.empty()) {
    const Status written = write_convergence_plot(*results, options.plot);
    if (!written) return fail(written.error());
  }
  return static_cast<int>(passed ? Exit::ok : Exit::task_failed);
}

}  // namespace

CLI::App* add_verify_command(CLI::App& app, VerifyOptions& options) {
  CLI::App* command = app.add_subcommand("verify", "solve cases with exact solutions and judge the errors");
  command->footer(kExamples);
  command->add_option("CASE", options.name, "a case of docs/verification.md, all of them, or hard")
      ->capture_default_str();
  command->add_option("--bins", options.bins, "classes along each solid, instead of the case's own grids");
  command->add_option("--tolerance", options.tolerance, "relative tolerance of the time steps")
      ->check(CLI::Range(1e-12, 0.1))
      ->capture_default_str();
  command->add_flag("--json", options.as_json, "one JSON document");
  command->add_option("--plot", options.plot, "draw the convergence into this SVG file");
  return command;
}

// Each suite has its own tables and its own exit code; a name that is no exact solution's selects another suite here.
int run_verify_command(const VerifyOptions& options) {
  const std::string hard = "hard";
  if (options.name == hard) return verify_hard("", options.as_json);
  if (options.name.rfind(hard + ":", 0) == 0) return verify_hard(options.name.substr(hard.size() + 1), options.as_json);
  return verify_exact(options);
}

}  // namespace granary::pbm
