// How DEM and PBM are coupled: the numbers the state machine decides by. Their meaning in full: docs/coupling.md.
#pragma once

namespace granary::coupling {

enum class Mode { two_way, one_way, pbm_only };

struct Settings {
  Mode mode = Mode::two_way;
  double threshold = 0.15;          ///< relative change that ends a burst; also the bound of "steady" in the DEM [-]
  double steady_window = 5.0;       ///< DEM time over which nothing may move, counted across bursts [s]
  double steady_tolerance = 0.05;   ///< largest change of the coupled state between two whole rounds [-]
  double significance = 3.0;        ///< a change of a count is one only beyond this many standard errors
  double grace = 0.2;               ///< DEM time at the start of a burst that is not looked at [s]
  double longest_dem_burst = 1.0;   ///< [s] of DEM time
  double longest_pbm_burst = 10.0;  ///< [s] of process time
  int least_rounds = 2;             ///< whole rounds before "steady" may be said (at least 2: one to compare with)
  int most_rounds = 50;
  double process_start = 0.0;       ///< [s] of process time
  double earliest_steady = 0.0;     ///< [s] of process time: what begins before it (a spray) has gone through by then
  double process_duration = 100.0;  ///< [s] of process time from process_start

  double process_end() const { return process_start + process_duration; }
};

}  // namespace granary::coupling
