// The report page of a sweep: its table, its curves, and each figure against the settings.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"
#include "controller/report/plotter.hpp"
#include "controller/sweep/results.hpp"

namespace granary::sweep {

/// Errors: those of the plotter.
Result<std::string> page(const SweepResults& results, report::Plotter& plotter);

/// sweep.json, sweep.csv, results.h5 and, if asked for, report.html (with gnuplot). Errors: a full disk; no gnuplot.
Status write_results(const SweepResults& results, const std::filesystem::path& dir, bool with_page);

}  // namespace granary::sweep
