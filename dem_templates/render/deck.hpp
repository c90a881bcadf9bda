// The files granary-dem starts from: input script, population and meshes of one burst (docs/exchange_formats.md).
// Starting it is the pilot's work.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "dem_templates/case/dem_case.hpp"
#include "dem_templates/geometry/machine.hpp"

namespace granary::dem {

/// Whole steps of the burst's parts.
struct Schedule {
  long settle = 0, window = 0, steps = 0;  ///< window is a multiple of Tally::every, steps one of window
  long sample = 0;                         ///< of fragments: a whole part of window, or whole windows; 0: none
};
Schedule schedule_of(const DemCase& dem_case);

/// Extra reach of the neighbour lists [m] while the bed settles, or where no other is tried out (docs/dem.md).
double neighbour_skin(const DemCase& dem_case);

/// Commands between two runs that choose that reach by a trial; none where one is stated, or with stock walls.
std::string skin_trial(const DemCase& dem_case);

/// The LIGGGHTS input script. Pure. Errors: only our own (a template that does not fit).
Result<std::string> input_script(const DemCase& dem_case, const std::vector<Body>& all);

/// population.json.
json::Value population_json(const DemCase& dem_case);

/// Writes case.json, population.json, meshes/*.stl and in.liggghts into `folder` (made if missing). A relative
/// `restart` is relative to `folder`, where granary-dem runs. Errors: what read_case() refuses; a user's STL that
/// cannot be used; a restart that is missing or belongs to another machine; a full disk.
Status write_burst(const DemCase& dem_case, const std::filesystem::path& folder);

}  // namespace granary::dem
