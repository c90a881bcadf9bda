// granary estimate: the parameters of a population balance from data, without a DEM.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/commands/commands.hpp"
#include "controller/commands/estimate.hpp"
#include "controller/commands/finish.hpp"
#include "controller/commands/past.hpp"
#include "controller/estimation/adoption.hpp"
#include "controller/estimation/crew_settings.hpp"
#include "controller/estimation/estimation_run.hpp"
#include "controller/estimation/estimation_text.hpp"
#include "controller/estimation/problem_of.hpp"

namespace granary::commands {
namespace fs = std::filesystem;
using campaign::Campaign;
using estimating::Crew;

namespace {

constexpr double kRewritePeriod = 0.5;  // [s]
constexpr double kLinePeriod = 5.0;     // [s]

/// One line on stderr: rewritten on a terminal, else now and then.
class ProgressLine {
 public:
  ProgressLine(const Crew& crew, const Campaign& campaign, pilot::EventLoop& loop, bool quiet)
      : crew_(crew), campaign_(campaign), loop_(loop), quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

  void show(bool last = false) {
    const double period = terminal_ ? kRewritePeriod : kLinePeriod;
    if (quiet_ || (!last && loop_.now() - shown_ < period)) return;
    shown_ = loop_.now();
    fmt::print(stderr, "{}{:>8.1f} s  {}{}", terminal_ ? "\r\033[K" : "", loop_.now(),
               estimating::progress_text(crew_, *campaign_.estimation), terminal_ && !last ? "" : "\n");
    std::fflush(stderr);
  }

 private:
  const Crew& crew_;
  const Campaign& campaign_;
  pilot::EventLoop& loop_;
  bool quiet_, terminal_;
  double shown_ = -1e300;
};

Result<Campaign> read(const RunOptions& options) {
  GRANARY_TRY(Campaign campaign, campaign::read_campaign(options.workflow, options.overrides));
  if (!campaign.estimation)
    return Error{
        fmt::format("{}: it has no section \"estimation\": say what is to be fitted to what. See "
                    "docs/workflow_format.md#estimation",
                    options.workflow.string())};
  // Said before a folder is made: an experiment may need rates that only a DEM can give.
  GRANARY_TRY([[maybe_unused]] const auto problem, estimating::problem_of(campaign));
  return campaign;
}

constexpr coupling::BurstId kFinalRun{1, coupling::Kind::pbm};

/// The balance of the first experiment with the estimate, as a campaign's burst: what it gives is kept and reported as
/// any balance's is.
Result<std::vector<pilot::TaskSpec>> final_run(Session& session, const estimation::Problem& problem, const Crew& crew,
                                               const run::FileHandover& handover) {
  using Adopt = campaign::Estimation::Adopt;
  if (session.campaign.estimation->adopt == Adopt::never || !crew.best()) return std::vector<pilot::TaskSpec>();
  GRANARY_TRY(const auto values, estimating::final_values(session.journal, crew.best(), session.pilot->now()));
  json::Value document =
      estimation::with_parameters(problem.experiments.front().segments.front(), problem.parameters, values);
  const fs::path folder = fs::path("bursts") / kFinalRun.folder();
  GRANARY_CHECK(make_folders(session.dir / folder));
  GRANARY_CHECK(json::write_file(session.dir / folder / "case.json", document.set("name", kFinalRun.folder())));
  pilot::TaskSpec task = handover.pbm_task();
  task.name = run::program_name(kFinalRun, 1);
  task.dir = folder;
  return std::vector{std::move(task)};
}

/// Nothing was coupled: what there is to report is the estimation, and the run with it.
coupling::State ended(const Session& session, bool complete) {
  coupling::State state;
  state.phase = coupling::Phase::ended;
  state.ended = complete ? coupling::End::How::limit : coupling::End::How::stopped;
  state.why_ended.message = complete ? "the parameters' intervals are known, or all evaluations are used up"
                                     : "stopped before the parameters' intervals were known";
  if (complete && session.pilot->find(run::program_name(kFinalRun, 1))) {
    const pbm::PbmCase& balance = session.campaign.estimation->experiments.front().balance;
    state.bursts.push_back({kFinalRun, 1, "end", balance.start_time, balance.end_time, "with the estimate"});
  }
  return state;
}

}  // namespace

bool is_estimate(const Session& session) { return !session.journal.records(kEstimateBegan).empty(); }

Result<Exit> run_estimate(Session& session, bool json, bool quiet) {
  GRANARY_TRY(const estimation::Problem problem, estimating::problem_of(session.campaign));
  if (!is_estimate(session)) GRANARY_CHECK(session.journal.append(kEstimateBegan, json::Value::object()));
  estimating::CrewSettings settings =
      estimating::crew_settings(*session.campaign.estimation, session.dir, program_folder(), session.machine.n_cores());
  settings.until_done = true;
  Crew crew(std::move(settings));
  GRANARY_CHECK(crew.begin(problem));

  ProgressLine progress(crew, session.campaign, session.loop, quiet);
  const run::FileHandover handover(session.campaign, session.dir, program_folder());
  estimating::EstimationRun run(
      crew, *session.pilot, session.loop, [&] { progress.show(); },
      [&] { return final_run(session, problem, crew, handover); });
  session.stop_on_signals([&](const std::string& message) { session.pilot->stop_all(message); });
  GRANARY_CHECK(session.serve([&](const json::Value& request) {
    json::Value answer = session.pilot->answer(request);
    if (request.text_or("ask", "") == "status") answer.set("estimation", crew.status());
    return answer;
  }));
  GRANARY_CHECK(run.begin());
  session.loop.run();
  progress.show(true);
  if (session.pilot->failure()) return *session.pilot->failure();
  if (run.failure()) return *run.failure();

  const json::Value report =
      estimating::report_json(crew, problem, session.pilot->usage(), session.pilot->now(), session.dir);
  GRANARY_CHECK(json::write_file(session.dir / "estimation" / "report.json", report));
  GRANARY_CHECK(crew.write_best());
  GRANARY_TRY([[maybe_unused]] const CampaignResults results,
              finish(session, handover, ended(session, run.complete())));
  if (json)
    fmt::print("{}\n", json::dump(report, 1));
  else
    fmt::print("{}", estimating::report_text(report, *session.campaign.estimation));
  if (run.complete()) return crew.best() ? Exit::ok : Exit::task_failed;
  fmt::print(stderr, "stopped; go on with: granary resume {}\n", session.dir.string());
  return Exit::stopped;
}

Result<Exit> estimate(const RunOptions& options) {
  GRANARY_TRY(Campaign campaign, read(options));
  const fs::path dir = run_folder(options.dir, campaign.name);
  if (fs::exists(dir / "journal.jsonl"))
    return Error{
        fmt::format("{}: a campaign is there already. Go on with it: granary resume {}; or choose another "
                    "--dir.",
                    dir.string(), dir.string())};
  GRANARY_CHECK(make_folders(dir));
  if (!options.quiet) fmt::print(stderr, "{} -> {}\n", options.workflow.string(), dir.string());
  GRANARY_CHECK(json::write_file(dir / "campaign.json", campaign::to_json(campaign)));
  GRANARY_TRY(const auto session, open_session(dir, std::move(campaign), {options.cores, options.virtual_nodes}));
  const auto exit = run_estimate(*session, options.json, options.quiet);
  if (exit && *exit == Exit::stopped) session->submit_next_job();
  return exit;
}

}  // namespace granary::commands
