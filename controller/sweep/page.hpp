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

/// The figures of the page as SVG files "PREFIXtime-d50-m.svg". Errors: those of the plotter; a full disk.
Status write_figures(const SweepResults& results, report::Plotter& plotter, const std::filesystem::path& folder,
                     const std::string& prefix);

/// sweep.json, sweep.csv, sweep_means.csv (where cases are repeated), results.h5 and, if asked for, report.html (with
/// gnuplot). Errors: a full disk; no gnuplot.
Status write_results(const SweepResults& results, const std::filesystem::path& dir, bool with_page);

}  // namespace granary::sweep
