// Draws plots with gnuplot: one process for all plots of a page, SVG on its standard output.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "controller/report/plotter.hpp"

namespace granary::report {

class GnuplotPlotter : public Plotter {
 public:
  /// Errors: gnuplot is not there (says which package has it), fails (with what it printed), or does not end in a
  /// minute.
  Result<std::vector<std::string>> draw(const std::vector<Plot>& plots) override;
};

/// The whole input of the process: a common style, and each plot from a clean state.
std::string gnuplot_input(const std::vector<Plot>& plots);

/// What gnuplot printed -> one <svg> element a plot, as it may stand inside an HTML page: no XML prolog, ids of its
/// own, no size but its view box. Errors: fewer or more drawings than plots.
Result<std::vector<std::string>> split_drawings(std::string_view printed, const std::vector<Plot>& plots);

/// An <svg> element as a file by itself.
std::string as_file(std::string svg);

}  // namespace granary::report
