// The plots of the DEM's bench, by gnuplot.
#pragma once

#include <filesystem>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::bench {

/// dem_choices.svg: error of the collision rate and of the impact speed against what a second of process costs.
/// dem_speed.svg: time per step of both codes. Whatever the document holds of them, into `folder` (made if missing).
/// Errors: no gnuplot (says which package has it), or it fails; the folder cannot be written.
Status draw_dem(const json::Value& document, const std::filesystem::path& folder);

}  // namespace granary::bench
