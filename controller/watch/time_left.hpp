// How long a campaign may still take. Pure; every estimate says what it rests on.
#pragma once

#include "controller/watch/view.hpp"

namespace granary::watch {

/// Of a coupled campaign, from the bursts that are over. Let T be the mean wall time of a whole round (of the last
/// three) and t the time since the current round began; P the process time of a round (likewise):
///
///   least = T r - t,   r = max(least_rounds - rounds, rounds until the DEM can have been quiet for its window, 1)
///   most  = T R - t,   R = min(most_rounds - rounds, (process_end - process_time) / P rounded up)
///
/// A PBM that runs alone to its end: its wall time so far over its share of the process time.
/// @param now  pilot time [s]; nothing before there is anything to go by.
std::optional<TimeLeft> time_left_coupled(const View& view, double longest_dem_burst, double now);

/// Of a list of tasks: `left` tasks at the mean rate of the ends so far.
std::optional<TimeLeft> time_left_tasks(std::int64_t ended, std::int64_t left, double now);

}  // namespace granary::watch
