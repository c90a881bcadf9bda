// granary-pbm bench: its part of the command line. `granary bench pbm` starts it part by part and shows the results.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace granary::pbm {

struct BenchOptions {
  std::string part;  ///< rhs, work-precision, temporal, published, row or twins
  bool quick = false, full = false;
  int threads = 1;                   ///< row only
  double seconds = 1.0;              ///< row only: wall time of each of its two measurements [s]
  int seeds = 0;                     ///< twins only: of each problem; 0: 20
  std::vector<int> parameters;       ///< twins only: 2, 4, 6; empty: all
  std::vector<std::string> methods;  ///< twins only; empty: all
  bool product = false;              ///< twins only: the one in which only a product can be found, alone
  bool write = false;                ///< twins only: print one problem, with what was hidden
};

/// Adds the subcommand; the options are filled in when the command line is parsed.
CLI::App* add_bench_command(CLI::App& app, BenchOptions& options);

/// Runs the part, prints one JSON document, and returns the exit code. All parts but row run on one thread.
int run_bench_command(const BenchOptions& options);

}  // namespace granary::pbm
