// What the coupling needs from the world: a burst made ready, its clock, its result carried over to the other side.
// file_handover does it with real folders, simulated_handover with a cost model: the same campaign runs on both.
#pragma once

#include <optional>
#include <string>

#include "common/result.hpp"
#include "controller/coupling/action.hpp"
#include "controller/coupling/summary.hpp"
#include "controller/monitor/verdict.hpp"
#include "pilot/task/spec.hpp"
#include "pilot/task/state.hpp"

namespace granary::run {

/// The programs of a burst, ready for the pilot.
struct BurstTasks {
  pilot::TaskSpec program;
  std::optional<pilot::TaskSpec> monitor;
};

class Handover {
 public:
  virtual ~Handover() = default;

  /// Makes the burst's folder ready to run. Doing it again gives the same.
  virtual Result<BurstTasks> prepare(const coupling::StartBurst& start) = 0;
  /// A monitor that reads what a burst left behind and says its last word, where the one beside it is gone.
  virtual pilot::TaskSpec late_monitor(const coupling::BurstId& burst, int attempt) = 0;
  /// The clock of the burst's program when it ended [s]; nothing if it never got as far.
  virtual std::optional<double> clock(const coupling::BurstId& burst, const pilot::TaskEnd& program) = 0;
  /// What the monitor said. Error: it could not do its work (its own words).
  virtual Result<monitor::Verdict> verdict(const coupling::BurstId& burst, const pilot::TaskEnd& monitor) = 0;
  /// Why a program failed, in its own words: its last lines.
  virtual std::string last_words(const pilot::TaskEnd& program) = 0;
  /// Carries a burst's result over. The next prepare() of the other kind builds on it.
  virtual Result<coupling::DemSummary> carry_dem(const coupling::Exchange& exchange) = 0;
  virtual Result<coupling::PbmSummary> carry_pbm(const coupling::Exchange& exchange) = 0;
};

/// Names of a burst's tasks: "0001-dem", "0001-dem-monitor"; a further attempt adds ".2".
std::string program_name(const coupling::BurstId& burst, int attempt);
std::string monitor_name(const coupling::BurstId& burst, int attempt);
/// What a task does for the campaign, by its name: dem, pbm, monitor, estimation (every filler) or other.
std::string kind_of_task(const std::string& name, bool fill);

}  // namespace granary::run
