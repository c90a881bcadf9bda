#include "controller/run/simulated_handover.hpp"

#include <algorithm>
#include <cmath>

namespace granary::run {
using coupling::Kind;

namespace {

/// How many cores' worth n ranks or threads do together.
double effective_cores(int n, double loss) { return n * std::pow(1.0 - loss, std::log2(static_cast<double>(n))); }

/// Wall seconds of a second of DEM time.
double dem_rate(const campaign::Campaign& campaign, double particles) {
  const auto& cost = campaign.cost_model;
  const double step = cost.dem_per_step + particles * cost.dem_per_particle_step /
                                              effective_cores(campaign.dem_case.ranks, cost.parallel_loss);
  return step / campaign.dem_case.time_step;
}

/// Wall seconds of a second of process time.
double pbm_rate(const campaign::Campaign& campaign) {
  const auto& cost = campaign.cost_model;
  const double classes = campaign.pbm_case.grid.bins[0] * campaign.pbm_case.grid.bins[1];
  const double pairs = 0.5 * classes * (classes + 1.0) * campaign.pbm_case.compartments.count;
  const int cores = campaign.pbm.ranks * campaign.pbm.threads;
  return cost.pbm_rates_per_second * pairs * cost.pbm_per_pair / effective_cores(cores, cost.parallel_loss);
}

}  // namespace

double dem_seconds(const campaign::Campaign& campaign, double duration) {
  double particles = 0.0;
  for (const dem::Population& held : campaign.dem_case.population)
    for (const long n : held.count) particles += static_cast<double>(n);
  return campaign.cost_model.dem_start + (duration + campaign.dem_case.settle_time) * dem_rate(campaign, particles);
}

double pbm_seconds(const campaign::Campaign& campaign, double duration) {
  return campaign.cost_model.pbm_start + duration * pbm_rate(campaign);
}

Result<BurstTasks> SimulatedHandover::prepare(const coupling::StartBurst& start) {
  const auto& cost = campaign_->cost_model;
  const bool dem = start.burst.kind == Kind::dem;
  Plan plan;
  plan.start = start;
  plan.seconds_per_second =
      dem ? dem_rate(*campaign_, static_cast<double>(campaign_->dem.particles)) : pbm_rate(*campaign_);
  plan.start_up = dem ? cost.dem_start + campaign_->dem_case.settle_time * plan.seconds_per_second : cost.pbm_start;
  plan.says_after = dem ? std::max(campaign_->coupling.grace, cost.dem_drift_after) : cost.pbm_drift_after;
  // Once nothing moves any more the monitor has nothing to report before the burst's own end.
  const bool moves = start.watch_drift && !settled(start.burst) && plan.says_after < start.longest;
  plan.says = moves                  ? monitor::Outcome::drifted
              : settled(start.burst) ? monitor::Outcome::steady
                                     : monitor::Outcome::ended;
  if (!moves) plan.says_after = start.longest;

  BurstTasks tasks;
  tasks.program.name = program_name(start.burst, start.attempt);
  tasks.program.command = {dem ? "granary-dem" : "granary-pbm"};
  tasks.program.ranks = dem ? campaign_->dem_case.ranks : campaign_->pbm.ranks;
  tasks.program.threads = dem ? 1 : campaign_->pbm.threads;
  tasks.program.priority = 10;
  plans_[tasks.program.name] = plan;
  if (start.monitored) {
    tasks.monitor.emplace();
    tasks.monitor->name = monitor_name(start.burst, start.attempt);
    tasks.monitor->command = {"granary-monitor"};
    tasks.monitor->light = true;
    plans_[tasks.monitor->name] = plan;
  }
  return tasks;
}

pilot::SimulatedRun SimulatedHandover::run_of(const pilot::TaskSpec& spec) const {
  pilot::SimulatedRun run;
  const auto found = plans_.find(spec.name);
  if (found == plans_.end()) {
    constexpr double kBatch = 3.0;  // of evaluations
    run.seconds = spec.fill ? kBatch : 1.0;
    return run;
  }
  const Plan& plan = found->second;
  const double clock_seconds = spec.light ? plan.says_after : plan.start.longest;
  run.seconds = plan.start_up + clock_seconds * plan.seconds_per_second;
  if (spec.light) run.exit_code = monitor::exit_code(plan.says);
  return run;
}

pilot::TaskSpec SimulatedHandover::late_monitor(const coupling::BurstId& burst, int attempt) {
  pilot::TaskSpec task;
  task.name = monitor_name(burst, attempt) + "-late";
  task.command = {"granary-monitor"};
  task.light = true;
  plans_[task.name] = plans_.at(monitor_name(burst, attempt));
  return task;
}

std::optional<double> SimulatedHandover::clock(const coupling::BurstId&, const pilot::TaskEnd& program) {
  const Plan& plan = plans_.at(program.name);
  const double ran = std::max(0.0, program.end - program.start - plan.start_up) / plan.seconds_per_second;
  return plan.start.start_time + std::min(plan.start.longest, ran);
}

Result<monitor::Verdict> SimulatedHandover::verdict(const coupling::BurstId&, const pilot::TaskEnd& monitor) {
  const Plan& plan = plans_.at(monitor.name);
  monitor::Verdict verdict;
  verdict.outcome = monitor.state == pilot::TaskState::stopped && plan.says == monitor::Outcome::drifted
                        ? monitor::Outcome::ended
                        : plan.says;
  verdict.burst_start = plan.start.start_time;
  verdict.time = plan.start.start_time + plan.says_after;
  verdict.change = verdict.outcome == monitor::Outcome::drifted ? campaign_->coupling.threshold : 0.0;
  verdict.threshold = campaign_->coupling.threshold;
  verdict.message = "assumed by the cost model";
  return verdict;
}

std::string SimulatedHandover::last_words(const pilot::TaskEnd& program) { return program.reason; }

// After the model's number of rounds the state stands still; before, each round moves it by more than any tolerance.
Result<coupling::DemSummary> SimulatedHandover::carry_dem(const coupling::Exchange& exchange) {
  const double level = std::pow(2.0, std::min(exchange.burst.round, campaign_->cost_model.rounds_until_steady));
  coupling::DemSummary summary;
  summary.start_time = plans_.at(program_name(exchange.burst, exchange.attempt)).start.start_time;
  summary.end_time = exchange.time;
  summary.particles = static_cast<double>(campaign_->dem.particles);
  summary.collision_frequency = level;
  summary.impact_frequency = level;
  summary.collisions = summary.impacts = 1e6;
  return summary;
}

Result<coupling::PbmSummary> SimulatedHandover::carry_pbm(const coupling::Exchange& exchange) {
  const double level = std::pow(2.0, std::min(exchange.burst.round, campaign_->cost_model.rounds_until_steady));
  const auto count = static_cast<std::size_t>(campaign_->pbm_case.compartments.count);
  return coupling::PbmSummary{exchange.time, std::vector<double>(count, level),
                              std::vector<double>(count, 1.0 / level)};
}

}  // namespace granary::run
