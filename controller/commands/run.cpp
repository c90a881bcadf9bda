#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <optional>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/commands/commands.hpp"
#include "controller/commands/estimate.hpp"
#include "controller/commands/finish.hpp"
#include "controller/commands/run_sweep.hpp"
#include "controller/commands/session.hpp"
#include "controller/report/report.hpp"
#include "controller/run/campaign_estimation.hpp"
#include "controller/run/collect.hpp"
#include "controller/run/progress.hpp"
#include "controller/run/provenance.hpp"
#include "controller/run/summary.hpp"
#include "pilot/launch/command.hpp"
#include "pilot/task_list.hpp"

namespace granary::commands {
namespace fs = std::filesystem;
using campaign::Campaign;

namespace {

/// Every program the campaign will need, before anything is started: all that are missing at once.
Status check_programs(const Campaign& campaign) {
  const bool sweep = campaign.kind == campaign::Kind::sweep;
  const bool dem = sweep ? campaign.sweep.solver == campaign::Sweep::Solver::dem
                         : campaign.coupling.mode != campaign::CouplingSettings::Mode::pbm_only;
  std::vector<std::string> wanted;
  if (!sweep || !dem) wanted.push_back((program_folder() / "granary-pbm").string());
  if (!sweep) wanted.push_back((program_folder() / "granary-monitor").string());
  if (dem) wanted.push_back((program_folder() / "granary-dem").string());
  if (dem || campaign.pbm.ranks > 1) wanted.emplace_back("mpirun");
  if (campaign.outputs.report) wanted.emplace_back("gnuplot");
  const char* path = std::getenv("PATH");
  std::string missing;
  for (const std::string& program : wanted)
    if (const auto found = pilot::find_executable(program, "", path != nullptr ? path : ""); !found)
      missing += (missing.empty() ? "" : "\n") + found.error().message;
  if (missing.empty()) return {};
  return Error{missing + "\n./dev build installs and builds all that a campaign needs."};
}

Result<Exit> run_coupled(Session& session, bool json, bool quiet) {
  run::FileHandover handover(session.campaign, session.dir, program_folder());
  run::Progress progress(session.loop, session.dir, quiet);
  std::unique_ptr<run::CampaignEstimation> estimation;
  if (session.campaign.estimation) {
    estimation = std::make_unique<run::CampaignEstimation>(session.campaign, session.dir, program_folder(), handover,
                                                           *session.pilot, session.loop, session.journal,
                                                           progress.watcher().note);
    handover.adopt_with([&estimation](json::Value pbm_case, const coupling::StartBurst& start) {
      return estimation->adopted(std::move(pbm_case), start);
    });
  }
  run::CampaignRun campaign_run(run::coupling_settings(session.campaign), handover, *session.pilot, session.loop,
                                session.journal, progress.watcher(), estimation.get());
  session.pilot->on_idle([&] {
    if (campaign_run.ended() || campaign_run.failure() || session.pilot->failure()) session.loop.stop();
  });
  const auto ask_stop = [&](const std::string& message) { campaign_run.ask_stop(message); };
  session.stop_on_signals(ask_stop);
  GRANARY_CHECK(session.serve([&](const json::Value& request) {
    if (request.text_or("ask", "") == "stop" && request["task"].is_null()) {
      ask_stop(request.text_or("reason", "stopped by the user"));
      return json::Value::object({{"stopping", true}});
    }
    json::Value answer = session.pilot->answer(request);
    if (request.text_or("ask", "") == "status") {
      answer.set("coupling", coupling::to_json(campaign_run.state()));
      if (estimation) answer.set("estimation", estimation->status());
    }
    return answer;
  }));
  GRANARY_CHECK(campaign_run.begin());
  session.loop.run();
  progress.finish();
  if (session.pilot->failure()) return *session.pilot->failure();
  if (campaign_run.failure()) return *campaign_run.failure();

  GRANARY_TRY(const CampaignResults results, finish(session, handover, campaign_run.state()));
  const fs::path results_h5 = session.dir / "results.h5";
  const fs::path report_html = session.campaign.outputs.report ? session.dir / "report.html" : fs::path();
  if (json) {
    fmt::print("{}\n", json::dump(run::summary_json(results, results_h5, report_html), 1));
  } else {
    fmt::print("{}", run::summary_text(results, results_h5, report_html));
  }
  if (campaign_run.exit() == Exit::stopped)
    fmt::print(stderr, "stopped; go on with: granary resume {}\n", session.dir.string());
  if (campaign_run.exit() == Exit::task_failed && (json || quiet))
    return Error{fmt::format("{}: {}", session.dir.string(), campaign_run.state().why_ended.message),
                 Exit::task_failed};
  return campaign_run.exit();
}

Result<Exit> run_tasks(Session& session, bool json) {
  session.stop_on_signals([&](const std::string& message) { session.pilot->stop_all(message); });
  GRANARY_CHECK(session.serve([&](const json::Value& request) { return session.pilot->answer(request); }));
  GRANARY_TRY(const pilot::TaskListSummary summary,
              pilot::run_task_list(session.campaign.tasks, *session.pilot, session.loop));
  if (json) {
    fmt::print("{}\n", json::dump(summary.json(), 1));
  } else {
    fmt::print("{}", run::timeline_text(session.pilot->timeline(), session.pilot->usage()));
    fmt::print("{} finished, {} failed, {} stopped, {} not started, {:.2f} s\n", summary.finished, summary.failed,
               summary.stopped, summary.not_started, summary.seconds);
  }
  std::string failures;
  for (const pilot::TaskEnd& end : summary.ends)
    if (end.state == pilot::TaskState::failed)
      failures += (failures.empty() ? "" : "\n") + end.name + ": " + end.reason;
  if (!failures.empty()) return Error{failures, summary.exit};
  return summary.exit;
}

Result<Exit> run_session(Session& session, bool json, bool quiet) {
  using campaign::Kind;
  const auto exit = is_estimate(session)                   ? run_estimate(session, json, quiet)
                    : session.campaign.kind == Kind::tasks ? run_tasks(session, json)
                    : session.campaign.kind == Kind::sweep ? run_sweep(session, json, quiet)
                                                           : run_coupled(session, json, quiet);
  if (exit && *exit == Exit::stopped) session.submit_next_job();
  return exit;
}

}  // namespace

fs::path run_folder(const fs::path& given, const std::string& name) {
  fs::path folder = given.empty() ? fs::path("runs") / name : given;
  for (int n = 2; given.empty() && fs::exists(folder); ++n) folder = fs::path("runs") / fmt::format("{}-{}", name, n);
  return fs::absolute(folder).lexically_normal();
}

Result<Exit> run(const RunOptions& options) {
  if (options.dry_run) return dry_run(options);
  if (options.nodes > 0)
    return Error{
        "--nodes states a machine for --dry-run; a real run takes the cores of this machine (--cores), or of a job of "
        "Slurm (granary submit)."};
  GRANARY_TRY(Campaign campaign, campaign::read_campaign(options.workflow, options.overrides));
  const fs::path dir = run_folder(options.dir, campaign.name);
  if (fs::exists(dir / "journal.jsonl"))
    return Error{
        fmt::format("{}: a campaign is there already. Go on with it: granary resume {}; or choose another --dir.",
                    dir.string(), dir.string())};
  if (campaign.kind != campaign::Kind::tasks) GRANARY_CHECK(check_programs(campaign));
  GRANARY_CHECK(make_folders(dir));
  if (!options.quiet) fmt::print(stderr, "{} -> {}\n", options.workflow.string(), dir.string());
  // Before the journal: a resume must find the workflow as it was understood.
  GRANARY_CHECK(json::write_file(dir / "campaign.json", campaign::to_json(campaign)));
  GRANARY_TRY(const auto session, open_session(dir, std::move(campaign), {options.cores, options.virtual_nodes}));
  return run_session(*session, options.json, options.quiet);
}

Result<Exit> resume(const fs::path& dir, bool json, bool quiet, int virtual_nodes) {
  const fs::path absolute = fs::absolute(dir).lexically_normal();
  if (!fs::exists(absolute / "campaign.json"))
    return Error{fmt::format("{}: no campaign is there (no campaign.json). Start one: granary run WORKFLOW --dir {}",
                             dir.string(), dir.string())};
  GRANARY_TRY(Campaign campaign, campaign::read_written_campaign(absolute / "campaign.json"));
  GRANARY_TRY(const auto session, open_session(absolute, std::move(campaign), {0, virtual_nodes}));
  return run_session(*session, json, quiet);
}

}  // namespace granary::commands
