// Runs one helper program to its end and takes what it prints: for gnuplot and the like, outside the event loop.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace granary::pilot {

struct ProgramOutput {
  int exit_code = -1;  ///< -1: ended by a signal
  int signal = 0;
  std::string out;  ///< what it wrote to stdout
  std::string err;  ///< and to stderr
};

/// argv is executed as it is (argv[0] is looked up in PATH), `input` goes to its stdin. Blocks until it has ended.
/// Errors: no such program; it still runs after `timeout_s` (it is killed). An exit code other than 0 is no error here.
Result<ProgramOutput> run_program(const std::vector<std::string>& argv, std::string_view input, double timeout_s);

}  // namespace granary::pilot
