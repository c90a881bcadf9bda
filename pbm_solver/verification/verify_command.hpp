// granary-pbm verify: its part of the command line, and what it prints.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

namespace granary::pbm {

struct VerifyOptions {
  std::string name = "all";
  std::optional<int> bins;
  double tolerance = 1e-5;  ///< of the time steps
  bool as_json = false;
  std::string plot;  ///< SVG file of the convergence; empty: none
};

/// Adds the subcommand; the options are filled in when the command line is parsed.
CLI::App* add_verify_command(CLI::App& app, VerifyOptions& options);

/// Solves the cases asked for, prints the table or the JSON document, and returns the exit code: 2 bad input, 3 an
/// error beyond its bound.
int run_verify_command(const VerifyOptions& options);

}  // namespace granary::pbm
