// granary-pbm evaluate: many sets of parameters in one process, a line of residuals each. The files:
// docs/exchange_formats.md.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>

#include "common/result.hpp"

namespace granary::pbm {

struct EvaluateOptions {
  std::filesystem::path problem, trials, out;
};

CLI::App* add_evaluate_command(CLI::App& app, EvaluateOptions& options);

/// A line a trial, in order, each on its way to the disk before the next begins; then {"done": true}. A trial that
/// fails is a line that says why. Errors: files that cannot be read or written; trials of another number of values.
Status evaluate(const EvaluateOptions& options);

}  // namespace granary::pbm
