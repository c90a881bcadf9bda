// The twin experiments as a picture: how often the intervals hold the truth, and what a search costs.
#pragma once

#include <filesystem>
#include <string>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::bench {

/// What gnuplot is given: a point for each method and number of parameters of methods[].
std::string twins_script(const json::Value& document);

/// Draws it into an SVG file. Errors: no gnuplot (says which package has it), or it fails; no such folder.
Status draw_twins(const json::Value& document, const std::filesystem::path& file);

}  // namespace granary::bench
