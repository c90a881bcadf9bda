#include "pbm_solver/verification/verify_command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "common/json/io.hpp"
#include "pbm_solver/verification/verification.hpp"

namespace granary::pbm {
namespace {

using json::Value;

int fail(const Error& error) {
  std::fprintf(stderr, "granary-pbm: %s\n", error.message.c_str());
  return static_cast<int>(error.exit);
}

std::string or_dash(const char* format, double value) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

void print_heading() {
  fmt::print("{:<18}{:>5}{:>10}{:>9}{:>7}{:>9}{:>9}{:>9}{:>7}{:>8}  {}\n", "case", "bins", "L1 [%]", "bound", "order",
             "M00", "M20 [%]", "drift", "rhs", "s", "ok");
}

void print_row(const Verification& v) {
  fmt::print("{:<18}{:>5}{:>10}{:>9}{:>7}{:>9}{:>9}{:>9.0e}{:>7}{:>8.3f}  {}\n", v.name, v.bins,
             or_dash("{:.3f}", 100.0 * v.errors.l1_number), or_dash("{:.3g}", 100.0 * v.l1_bound),
             or_dash("{:.2f}", v.order), or_dash("{:+.0e}", v.moment("M00")),
             or_dash("{:+.2f}", 100.0 * v.moment("M20")), v.largest_drift(), v.rhs_evaluations, v.cpu,
             v.passed ? "yes" : "NO");
}

}  // namespace

CLI::App* add_verify_command(CLI::App& app, VerifyOptions& options) {
  CLI::App* command = app.add_subcommand("verify", "solve cases with exact solutions and judge the errors");
  command->add_option("CASE", options.name, "a case of docs/verification.md, or all")->capture_default_str();
  command->add_option("--bins", options.bins, "classes along each solid, instead of the case's own grids");
  command->add_option("--tolerance", options.tolerance, "relative tolerance of the time steps")
      ->check(CLI::Range(1e-12, 0.1))
      ->capture_default_str();
  command->add_flag("--json", options.as_json, "one JSON document");
  return command;
}

int run_verify_command(const VerifyOptions& options) {
  std::vector<Verification> all;
  std::string group;
  if (!options.as_json) print_heading();
  for (const std::string& name :
       options.name == "all" ? verification_names() : std::vector<std::string>{options.name}) {
    const auto results = verify_grids(name, options.bins, options.tolerance);
    if (!results) return fail(results.error());
    for (const Verification& v : *results) {
      if (!options.as_json) {
        if (v.group != group) fmt::print("{}\n", v.group);
        group = v.group;
        print_row(v);
      }
      all.push_back(v);
    }
  }
  bool passed = true;
  Value cases = Value::array();
  for (const Verification& v : all) {
    passed = passed && v.passed;
    cases.push(to_json(v));
  }
  if (options.as_json) std::printf("%s\n", json::dump(Value::object({{"cases", cases}}), 2).c_str());
  return static_cast<int>(passed ? Exit::ok : Exit::task_failed);
}

}  // namespace granary::pbm
