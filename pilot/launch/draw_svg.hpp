// Draws one picture with gnuplot: for programs that keep a plot beside their tables.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"

namespace granary::pilot {

/// Runs a script that sets the terminal svg and writes to its standard output, and puts the drawing into `file`.
/// Errors: gnuplot is not there (names the package), failed (its words), or drew nothing; `file` cannot be written.
Status draw_svg(const std::string& script, const std::filesystem::path& file);

}  // namespace granary::pilot
