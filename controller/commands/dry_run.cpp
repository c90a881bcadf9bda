#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <functional>
#include <map>

#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/commands/commands.hpp"
#include "controller/run/file_handover.hpp"
#include "controller/run/progress.hpp"
#include "controller/run/simulated_estimation.hpp"
#include "controller/run/simulated_handover.hpp"
#include "controller/run/summary.hpp"
#include "controller/sweep/cases.hpp"
#include "pilot/launch/simulated_launcher.hpp"
#include "pilot/loop/virtual_loop.hpp"
#include "pilot/task_list.hpp"

namespace granary::commands {
using campaign::Campaign;

namespace {

/// The machine asked for on the command line, else in the workflow, else two cores: a dry run needs no machine at all.
Result<pilot::Machine> machine_of(const Campaign& campaign, const RunOptions& options) {
  constexpr int kCores = 2;
  const int nodes = options.nodes > 0 ? options.nodes : campaign.resources.nodes;
  const int cores = options.cores > 0 ? options.cores : campaign.resources.cores.value_or(kCores);
  GRANARY_CHECK(campaign::check_resources(campaign, nodes, cores));
  return pilot::stated_machine(nodes, cores);
}

std::string submission(const pilot::Machine& machine) {
  return fmt::format("would be submitted: one pilot on {} node(s) of {} cores; every task below runs inside it\n",
                     machine.nodes.size(), machine.largest_node());
}

void print(const pilot::Pilot& pilot, const std::string& how, bool json) {
  if (json) {
    const auto usage = pilot.usage();
    fmt::print("{}\n", json::dump(json::Value::object({{"dry_run", true},
                                                       {"ended", how},
                                                       {"wall_s", pilot.now()},
                                                       {"nodes", pilot.machine().nodes.size()},
                                                       {"cores", pilot.machine().n_cores()},
                                                       {"core_use", usage.total > 0.0 ? usage.busy / usage.total : 0.0},
                                                       {"timeline", run::timeline_json(pilot.timeline())}}),
                                  1));
    return;
  }
  fmt::print("{}{}", submission(pilot.machine()), run::timeline_text(pilot.timeline(), pilot.usage()));
  fmt::print("would take {:.1f} s and end {} (by the cost model; nothing was started)\n", pilot.now(), how);
}

Result<Exit> dry_run_coupled(const Campaign& campaign, const pilot::Machine& machine, const RunOptions& options) {
  pilot::VirtualLoop loop;
  run::SimulatedHandover handover(campaign);
  pilot::SimulatedLauncher launcher(loop, [&](const pilot::TaskSpec& spec) { return handover.run_of(spec); });
  pilot::Journal journal = pilot::Journal::in_memory([&] { return loop.wall_time(); });
  GRANARY_TRY(const auto pilot,
              pilot::Pilot::open({std::filesystem::current_path(), machine}, loop, launcher, journal));
  run::Progress progress(loop, {}, options.quiet || options.json);
  run::SimulatedEstimation estimation(*pilot, loop, run::dem_seconds(campaign, campaign.dem_case.tally.window));
  run::CampaignRun campaign_run(run::coupling_settings(campaign), handover, *pilot, loop, journal, progress.watcher(),
                                campaign.estimation ? &estimation : nullptr);
  GRANARY_CHECK(campaign_run.begin());
  loop.run();
  if (!campaign_run.ended())
    return Error{"the dry run came to no end: the coupling waits for something that never happens.", Exit::internal};
  print(*pilot, std::string(coupling::name(*campaign_run.state().ended)), options.json);
  if (campaign_run.exit() == Exit::task_failed) return Error{campaign_run.state().why_ended.message, Exit::task_failed};
  return campaign_run.exit();
}

using Seconds = std::function<double(const pilot::TaskSpec&)>;

Result<Exit> dry_run_tasks(const std::vector<pilot::TaskSpec>& tasks, const pilot::Machine& machine,
                           const RunOptions& options, const Seconds& seconds) {
  pilot::VirtualLoop loop;
  pilot::SimulatedLauncher launcher(loop, [&](const pilot::TaskSpec& spec) {
    pilot::SimulatedRun run;
    run.seconds = seconds(spec);
    return run;
  });
  pilot::Journal journal = pilot::Journal::in_memory([&] { return loop.wall_time(); });
  GRANARY_TRY(const auto pilot,
              pilot::Pilot::open({std::filesystem::current_path(), machine}, loop, launcher, journal));
  GRANARY_TRY(const auto summary, pilot::run_task_list(tasks, *pilot, loop));
  print(*pilot, summary.exit == Exit::ok ? "finished" : "failed", options.json);
  return summary.exit;
}

/// What the cost model says of each case.
Seconds sweep_seconds(const Campaign& campaign) {
  std::map<std::string, double> seconds;
  for (const campaign::SweepCase& one : campaign.sweep.cases)
    seconds[sweep::task_name(one)] = campaign.sweep.solver == campaign::Sweep::Solver::dem
                                         ? run::dem_seconds(*one.understood, one.understood->duration)
                                         : run::pbm_seconds(*one.understood, one.understood->duration);
  return [seconds](const pilot::TaskSpec& spec) { return seconds.at(spec.name); };
}

}  // namespace

Result<Exit> dry_run(const RunOptions& options) {
  GRANARY_TRY(const Campaign campaign, campaign::read_campaign(options.workflow, options.overrides));
  GRANARY_TRY(const pilot::Machine machine, machine_of(campaign, options));
  if (campaign.kind == campaign::Kind::coupled) return dry_run_coupled(campaign, machine, options);
  if (campaign.kind == campaign::Kind::sweep)
    return dry_run_tasks(sweep::tasks_of(campaign, ""), machine, options, sweep_seconds(campaign));
  // Nobody knows how long a stranger's program takes: its timeout if it has one, else a second.
  return dry_run_tasks(campaign.tasks, machine, options,
                       [](const pilot::TaskSpec& spec) { return spec.timeout > 0.0 ? 0.5 * spec.timeout : 1.0; });
}

}  // namespace granary::commands
