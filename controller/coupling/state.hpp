// Where a coupled campaign stands. Everything the next decision needs, and nothing else; rebuilt by replaying the
// journal.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "controller/coupling/action.hpp"
#include "controller/coupling/event.hpp"
#include "controller/coupling/summary.hpp"

namespace granary::coupling {

enum class Phase {
  waiting,     ///< for Began
  running,     ///< the burst's program runs
  stopping,    ///< it was asked to stop
  closing,     ///< it has ended; the monitor's last word is missing
  exchanging,  ///< its result is on the way to the other side
  ended,
};

/// A burst that is over.
struct BurstRecord {
  BurstId burst;
  int attempt = 1;
  std::string reason;                       ///< drifted, steady, converged, longest, end
  double start_time = 0.0, end_time = 0.0;  ///< its own clock [s]; a PBM's end is where the DEM takes over
  std::string message;

  bool operator==(const BurstRecord&) const = default;
};

struct State {
  Phase phase = Phase::waiting;
  BurstId burst{1, Kind::dem};              ///< the one that runs, is exchanged, or is to be started on resume
  int attempt = 0;                          ///< of that burst
  std::optional<monitor::Verdict> verdict;  ///< its monitor's, once spoken
  std::optional<double> program_end;        ///< its program's clock at its end, once ended [s]
  bool stop_asked = false;
  std::string stop_message;
  std::string failure;  ///< why the campaign will fail once the program has stopped; "" if it will not

  double burst_start = 0.0;                     ///< clock of the current burst at its start [s]
  double dem_clock = 0.0, process_clock = 0.0;  ///< where the next DEM and PBM burst go on [s]
  std::vector<BurstRecord> bursts;              ///< those that are over
  std::vector<CoupledSummary> rounds;           ///< whole rounds (the last two suffice for the decision)
  std::optional<DemSummary> dem;                ///< of this round, until its PBM is exchanged too
  std::vector<DemSummary> steady_run;           ///< DEM bursts in a row among which nothing moved
  double steady_time = 0.0;                     ///< DEM time they span together [s]

  std::optional<End::How> ended;
  Why why_ended;

  bool operator==(const State&) const = default;
};

std::string_view name(Phase phase);
/// For `granary status`; not read back (the journal is).
json::Value to_json(const State& state);

}  // namespace granary::coupling
