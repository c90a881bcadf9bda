#include "controller/commands/run_sweep.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/commands/past.hpp"
#include "controller/report/gnuplot.hpp"
#include "controller/sweep/cases.hpp"
#include "controller/sweep/outcome.hpp"
#include "controller/sweep/page.hpp"
#include "pilot/task_list.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

namespace {

json::Value summary_json(const pilot::TaskListSummary& summary, const sweep::SweepResults& results, const fs::path& dir,
                         bool page) {
  json::Value all = summary.json();
  all.set("cases", sweep::to_json(results)["cases"]);
  all.set("table", (dir / "sweep.csv").string());
  all.set("results", (dir / "results.h5").string());
  all.set("report", page ? json::Value((dir / "report.html").string()) : json::Value());
  return all;
}

std::string failures_of(const pilot::TaskListSummary& summary) {
  std::string failures;
  for (const pilot::TaskEnd& end : summary.ends) {
    if (end.state != pilot::TaskState::failed) continue;
    failures += (failures.empty() ? "" : "\n") + end.name + ": " + end.reason;
    if (const auto said = read_text(end.dir / (end.name + ".out")); said && !said->empty())
      failures += "\n" + said->substr(said->size() > 2000 ? said->size() - 2000 : 0);
  }
  return failures;
}

}  // namespace

Result<Exit> run_sweep(Session& session, bool json, bool quiet) {
  GRANARY_TRY(const auto cut, sweep::prepare_cases(session.campaign, session.dir, *session.pilot));
  if (!cut.anew.empty() && !quiet)
    fmt::print(stderr, "cut in the middle, they start anew: {}\n", fmt::join(cut.anew, ", "));
  if (!cut.going_on.empty() && !quiet)
    fmt::print(stderr, "cut in the middle, they go on from their last state: {}\n", fmt::join(cut.going_on, ", "));
  session.stop_on_signals([&](const std::string& message) { session.pilot->stop_all(message); });
  GRANARY_CHECK(session.serve([&](const json::Value& request) { return session.pilot->answer(request); }));
  const auto tasks = sweep::tasks_of(session.campaign, program_folder());
  if (!quiet && !json)
    session.pilot->on_end([n = tasks.size(), done = 0](const pilot::TaskEnd& end) mutable {
      fmt::print(stderr, "{}/{}  {} {} after {:.1f} s\n", ++done, n, end.name, pilot::name_of(end.state),
                 end.end - end.start);
    });
  GRANARY_TRY(const auto summary, pilot::run_task_list(tasks, *session.pilot, session.loop));

  const bool page = session.campaign.outputs.report;
  GRANARY_TRY(const auto results, sweep::collect(session.campaign, session.dir, *session.pilot));
  GRANARY_CHECK(sweep::write_results(results, session.dir, page));
  if (json) {
    fmt::print("{}\n", json::dump(summary_json(summary, results, session.dir, page), 1));
  } else {
    fmt::print("{} finished, {} failed, {} stopped, {} not started, {:.1f} s\n{}\n{}\n", summary.finished,
               summary.failed, summary.stopped, summary.not_started, summary.seconds,
               (session.dir / "sweep.csv").string(), page ? (session.dir / "report.html").string() : "");
  }
  if (summary.exit == Exit::stopped)
    fmt::print(stderr, "stopped; go on with: granary resume {}\n", session.dir.string());
  if (const std::string failures = failures_of(summary); !failures.empty()) return Error{failures, summary.exit};
  return summary.exit;
}

Result<Exit> report_sweep(const fs::path& dir, const fs::path& figures, const std::string& prefix) {
  const fs::path absolute = fs::absolute(dir).lexically_normal();
  GRANARY_TRY(const auto past, past_of(absolute));
  GRANARY_TRY(const auto results, sweep::collect(past->campaign, absolute, *past->pilot));
  GRANARY_CHECK(sweep::write_results(results, absolute, true));
  if (!figures.empty()) {
    report::GnuplotPlotter gnuplot;
    GRANARY_CHECK(sweep::write_figures(results, gnuplot, figures, prefix));
  }
  fmt::print("{}\n", (absolute / "report.html").string());
  return Exit::ok;
}

}  // namespace granary::commands
