// The work-precision plot: error against CPU time, by gnuplot.
#pragma once

#include <filesystem>
#include <string>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::bench {

/// What gnuplot is given: one curve for each method and number of bins that was measured.
/// @param document  with work_precision[]
std::string work_precision_script(const json::Value& document);

/// Draws it into an SVG file. Errors: no gnuplot (says which package has it), or it fails; no such folder.
Status draw_work_precision(const json::Value& document, const std::filesystem::path& file);

}  // namespace granary::bench
