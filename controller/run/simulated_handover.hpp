// Bursts that only cost time: what a dry run hands over, and how long its tasks take, by the workflow's cost model.
#pragma once

#include <map>

#include "controller/campaign/campaign.hpp"
#include "controller/run/handover.hpp"
#include "pilot/launch/simulated_launcher.hpp"

namespace granary::run {

/// Cost model: a DEM burst takes
///   start-up + steps (per_step + particles per_particle_step / (ranks efficiency)),
/// a PBM burst start-up + process time * rates per second * compartments * pairs * per_pair / (ranks threads
/// efficiency); efficiency = (1 - parallel_loss)^log2(n). Monitors speak at the model's drift times; after
/// rounds_until_steady nothing moves.
class SimulatedHandover final : public Handover {
 public:
  explicit SimulatedHandover(const campaign::Campaign& campaign) : campaign_(&campaign) {}

  Result<BurstTasks> prepare(const coupling::StartBurst& start) override;
  pilot::TaskSpec late_monitor(const coupling::BurstId& burst, int attempt) override;
  std::optional<double> clock(const coupling::BurstId& burst, const pilot::TaskEnd& program) override;
  Result<monitor::Verdict> verdict(const coupling::BurstId& burst, const pilot::TaskEnd& monitor) override;
  std::string last_words(const pilot::TaskEnd& program) override;
  Result<coupling::DemSummary> carry_dem(const coupling::Exchange& exchange) override;
  Result<coupling::PbmSummary> carry_pbm(const coupling::Exchange& exchange) override;

  /// How long a task of ours takes, for the SimulatedLauncher.
  pilot::SimulatedRun run_of(const pilot::TaskSpec& spec) const;

 private:
  struct Plan {
    coupling::StartBurst start;
    double seconds_per_second = 0.0;  ///< wall time for a second of the burst's clock
    double start_up = 0.0;            ///< [s]
    monitor::Outcome says = monitor::Outcome::ended;
    double says_after = 0.0;  ///< on the burst's clock, since its start [s]
  };

  bool settled(const coupling::BurstId& burst) const {
    return burst.round >= campaign_->cost_model.rounds_until_steady;
  }

  const campaign::Campaign* campaign_;
  std::map<std::string, Plan> plans_;  ///< by task name, program and monitor
};

/// What the cost model says of one DEM, or one PBM, of so much of its clock [s].
double dem_seconds(const campaign::Campaign& campaign, double duration);
double pbm_seconds(const campaign::Campaign& campaign, double duration);

}  // namespace granary::run
