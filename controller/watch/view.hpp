// All that a viewer shows of a campaign at one moment: plain data, in SI. The watcher fills it; screen, plain lines and
// web page only draw it.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::watch {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// One burst, from its start on. Times without "pilot" are on the burst's own clock: DEM time or process time [s].
struct Burst {
  std::string folder;  ///< "0003-dem"
  bool dem = false;
  int round = 0;
  int attempt = 1;
  double start = 0.0, end = kUnknown;              ///< end: where the other side takes over; unknown while it runs
  double longest = 0.0;                            ///< it ends by itself so much later (a DEM's settling included)
  double pilot_start = 0.0, pilot_end = kUnknown;  ///< pilot time [s]
  std::string why_started;
  std::string reason, message;                             ///< why it ended: drifted, steady, longest, ...
  double particles = kUnknown;                             ///< DEM: in the DEM; PBM: real ones
  double collision_rate = kUnknown;                        ///< DEM: a particle's, at real sizes [1/s]
  double impact_rate = kUnknown;                           ///< [1/s]
  double d50_smallest = kUnknown, d50_largest = kUnknown;  ///< PBM: over the compartments [m]
};

/// One output of a PBM burst.
struct SizePoint {
  double time = 0.0;           ///< process time [s]
  std::vector<double> d50;     ///< [m], shape (compartments)
  std::vector<double> number;  ///< particles, shape (compartments)
};

/// One window of a DEM burst, as counted (DEM particles).
struct ContactPoint {
  double time = 0.0;  ///< DEM time [s]
  double particles = 0.0;
  double collisions = 0.0;  ///< that a particle takes part in, per time [1/s]
  double impacts = 0.0;     ///< per particle and time [1/s]
};

/// How near the campaign is to being steady. A comparison is of the last two whole rounds.
struct Steadiness {
  double quiet_time = 0.0, window = kUnknown;  ///< DEM time in which nothing moved; what is asked [s]
  int rounds = 0, least_rounds = 0, most_rounds = 0;
  double tolerance = kUnknown;            ///< largest change that still is steady [-]
  std::string changed, where;             ///< what changed most: "d50", "compartment 3"; "" while unknown
  double change = kUnknown, noise = 0.0;  ///< [-]
  bool dem_quiet = false, rounds_agree = false;
};

enum class Level { minor, usual, warning };

/// Something that happened, in words.
struct Happening {
  double time = 0.0;  ///< pilot time [s]
  Level level = Level::usual;
  std::string words;
};

struct RunningTask {
  std::string name, kind, state;
  int attempt = 1;
  std::vector<int> cores;
  double seconds = 0.0;
};

/// What an estimation beside the campaign has found so far.
struct Fit {
  struct Parameter {
    std::string name, unit;                  ///< unit: SI; "1": none
    double value = kUnknown;                 ///< of the best trial
    double low = kUnknown, high = kUnknown;  ///< 95 % interval; unknown before it was looked for
  };
  struct Point {
    double time = 0.0;  ///< pilot time [s]
    double cost = 0.0;  ///< half the sum of squares of the best trial so far; new rates begin anew
  };
  std::string phase;                              ///< search, uncertainty, posterior, done
  std::int64_t evaluations = 0;                   ///< failed ones too
  double misfit = kUnknown, held_out = kUnknown;  ///< squares of residuals per datum: fitted, held out
  std::vector<Parameter> parameters;
  std::vector<Point> points;
};

/// Mean number of busy cores in equal slices of the pilot's time, by kind of task.
struct CoreHistory {
  double slice = 1.0;                                             ///< [s]
  std::vector<std::pair<std::string, std::vector<double>>> busy;  ///< kind -> cores, shape (slices)
};

/// How long it may still take.
struct TimeLeft {
  double least = 0.0, most = 0.0;  ///< [s]; equal if there is only one estimate
  std::string how;                 ///< what it was estimated from
};

enum class Phase { waiting, running, stopping, finishing, ended };
std::string_view name(Phase phase);

struct View {
  std::string campaign, folder, description;
  bool coupled = false;
  std::string mode;  ///< of a coupled one: two-way, one-way, pbm-only
  Phase phase = Phase::waiting;
  std::string headline;      ///< what goes on, in one sentence
  std::optional<Exit> exit;  ///< once it has ended: what it ended with
  std::uint64_t journal_records = 0;

  double time = 0.0;  ///< pilot time [s]
  int nodes = 0, cores = 0, busy_cores = 0;
  double core_use = kUnknown, core_use_fillers = 0.0;  ///< share of all core seconds [-]
  std::vector<std::pair<std::string, int>> busy_by_kind;
  std::vector<std::pair<std::string, std::int64_t>> counts;  ///< tasks by state
  std::vector<RunningTask> tasks;
  std::int64_t fillers = 0, fillers_done = 0;
  CoreHistory core_history;

  std::optional<Burst> burst;    ///< the one that runs
  double burst_time = kUnknown;  ///< its clock [s]
  std::vector<Burst> bursts;     ///< those that are over
  double process_time = 0.0, process_end = kUnknown, dem_time = 0.0;
  std::vector<SizePoint> sizes;
  std::vector<ContactPoint> contacts;
  std::optional<Steadiness> steadiness;
  std::optional<Fit> fit;
  std::optional<TimeLeft> time_left;

  std::vector<Happening> happenings;  ///< the last ones, oldest first
  std::uint64_t n_happenings = 0;     ///< of all
  std::vector<std::string> warnings;  ///< what stands against a good end right now
};

/// Everything the page draws; long series are thinned to `most_points`, first and last kept.
json::Value to_json(const View& view, std::size_t most_points = 400);

}  // namespace granary::watch
