// A bare input script for timing: the same state, materials and machine for stock LIGGGHTS and for granary-dem, with
// nothing in it that only one of them has but the walls.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/result.hpp"
#include "dem_templates/case/dem_case.hpp"

namespace granary::bench {

/// A settled state of a case, the machine's blades where its meshes have them.
struct State {
  std::filesystem::path folder;  ///< holds state.data and meshes/
  long particles = 0;
};

/// Fills the case, lets it settle for whole turns with granary-dem, and writes it down for read_data.
/// A turn must be a whole number of time steps. `folder` is made.
Result<State> settled_state(const dem::DemCase& dem_case, int turns, const std::filesystem::path& folder);

struct TimingDeck {
  dem::Walls walls = dem::Walls::granary;
  std::optional<double> skin;  ///< [m]; none: granary/skin chooses (granary-dem only)
  long warm_up = 200;          ///< steps of the first `run`
  long steps = 1000;           ///< of the second, which is timed
  int windows = 0;             ///< of a granary/tally during the second; 0: no tally (granary-dem only)
};

/// The input script. Errors: the case's meshes.
Result<std::string> timing_deck(const dem::DemCase& dem_case, const TimingDeck& deck);

}  // namespace granary::bench
