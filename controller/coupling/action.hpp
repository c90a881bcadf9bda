// What the coupling wants done. Each action says why, with the numbers it was decided by, so the journal can keep them.
// Keyed by burst and attempt: doing one twice must do no harm.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "common/json/value.hpp"
#include "controller/coupling/event.hpp"

namespace granary::coupling {

/// Why: one sentence for a person, and the numbers.
struct Why {
  std::string reason;  ///< a word: "drifted", "longest", "begin", ...
  std::string message;
  json::Value numbers;  ///< an object

  bool operator==(const Why&) const = default;
};

/// Start the burst's program and its monitor.
struct StartBurst {
  BurstId burst;
  int attempt = 1;                 ///< 1 unless resumed or retried
  double start_time = 0.0;         ///< on the burst's own clock: DEM time or process time [s]
  double longest = 0.0;            ///< the program ends by itself this much later [s]
  std::optional<BurstId> restart;  ///< the earlier burst of its own kind whose state it goes on from; none: the first
  double restart_time = 0.0;       ///< PBM: the output time in that burst's out.h5 [s]; DEM: its restart file's time
  std::optional<BurstId>
      takes_from;           ///< the burst of the other kind it takes rates or sizes from; none: the given start
  bool monitored = true;    ///< false: the program runs to its end and needs no monitor
  bool watch_drift = true;  ///< false: the monitor must not stop the burst for a drift (one-way)
  Why why;
};

/// End the program gracefully; TaskEnded will follow.
struct StopTask {
  BurstId burst;
  int attempt = 1;
  Why why;
};

/// The program has ended: get the monitor's last word (SIGTERM makes it read to the end of the file and say it; where
/// none is running any more, run it with --finished). MonitorSpoke or MonitorFailed will follow.
struct AskMonitor {
  BurstId burst;
  int attempt = 1;
  Why why;
};

/// Carry the burst's result over to the other side. DemExchanged, PbmExchanged or ExchangeFailed will follow.
struct Exchange {
  BurstId burst;  ///< dem: tallies -> rates; pbm: state at `time` -> DEM population
  int attempt = 1;
  double time = 0.0;  ///< PBM: the output time to take [s]; DEM: its clock at the end [s]
  Why why;
};

struct End {
  enum class How { steady, limit, stopped, failed };
  How how = How::failed;
  Why why;
};

using Action = std::variant<StartBurst, StopTask, AskMonitor, Exchange, End>;

std::string_view name(End::How how);
/// For the journal: {"action": "start_burst", "burst": "0002-dem", ..., "why": {...}}.
json::Value to_json(const Action& action);

}  // namespace granary::coupling
