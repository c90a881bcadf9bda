#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/commands/commands.hpp"
#include "controller/commands/past.hpp"
#include "controller/commands/run_sweep.hpp"
#include "controller/commands/slurm_queue.hpp"
#include "controller/commands/status.hpp"
#include "controller/report/report.hpp"
#include "pilot/control/control.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

namespace {

/// Whether a campaign that nobody works on has anything left to do.
bool can_go_on(const json::Value& status) {
  const json::Value& coupling = status["coupling"];
  if (coupling.is_object()) {
    const std::string ended = coupling.text_or("ended", "");
    return ended.empty() || ended == "stopped";
  }
  const auto& counts = status["counts"].members_or_none();
  return counts.empty() || std::any_of(counts.begin(), counts.end(), [](const json::Member& state) {
           return state.first != "finished" && state.first != "failed";
         });
}

std::string how_to_go_on(const fs::path& dir) {
  const auto campaign = campaign::read_written_campaign(dir / "campaign.json");
  const bool slurm = campaign && campaign->resources.backend == campaign::Resources::Backend::slurm;
  return fmt::format("granary {} {}", slurm ? "submit" : "resume", dir.string());
}

}  // namespace

Result<Exit> validate(const std::vector<fs::path>& workflows, const std::vector<std::string>& overrides) {
  std::string problems;
  for (const fs::path& workflow : workflows) {
    if (const auto campaign = campaign::read_campaign(workflow, overrides)) {
      fmt::print("{}: valid ({})\n", workflow.string(), campaign->name);
    } else {
      if (campaign.error().exit != Exit::bad_input) return campaign.error();
      problems += (problems.empty() ? "" : "\n") + campaign.error().message;
    }
  }
  if (!problems.empty()) return Error{problems};
  return Exit::ok;
}

Result<Exit> status(const fs::path& dir, bool json) {
  GRANARY_TRY(json::Value status, campaign_status(dir));
  const bool alive = status["alive"].as_bool();
  const json::Value jobs = queue_status(dir);
  if (jobs.size() > 0) status.set("jobs", jobs);
  if (json) {
    fmt::print("{}\n", json::dump(status, 1));
    return Exit::ok;
  }
  fmt::print("{}: {}\n", dir.string(), alive ? "running" : "no pilot is alive here");
  for (const json::Value& job : jobs.items())
    fmt::print("  job {} of Slurm: {} ({})\n", job.text_or("job", ""), job.text_or("state", ""),
               job.text_or("reason", ""));
  for (const auto& [state, count] : status["counts"].members_or_none())
    fmt::print("  {:<10} {}\n", state, count.as_integer());
  if (alive)
    fmt::print("  cores busy {} of {}, {:.1f} s\n", status.integer_or("busy_cores", 0), status.integer_or("cores", 0),
               status.number_or("time_s", 0.0));
  for (const json::Value& task : status["tasks"].items_or_none())
    fmt::print("  {:<24} {:<10} attempt {} {:.1f} s\n", task.text_or("name", ""), task.text_or("state", ""),
               task.integer_or("attempt", 1), task.number_or("seconds", 0.0));
  const json::Value& coupling = status["coupling"];
  if (coupling.is_object())
    fmt::print("  coupling: {} {}, process clock {:.3f} s, DEM clock {:.3f} s\n", coupling.text_or("phase", ""),
               coupling.text_or("burst", ""), coupling.number_or("process_clock_s", 0.0),
               coupling.number_or("dem_clock_s", 0.0));
  // Of a living pilot its own word, else what it left behind.
  json::Value fit = status["estimation"];
  if (!fit.is_object())
    if (const auto best = json::read_file(dir / "estimation" / "best.json")) fit = *best;
  if (fit["parameters"].is_array())
    fmt::print("  estimation: {}, {} evaluations, {:.3g} squares per datum\n", fit.text_or("phase", ""),
               fit.integer_or("evaluated", 0), fit.number_or("chi_square_per_datum", 0.0));
  for (const json::Value& one : fit["parameters"].items_or_none())
    fmt::print("    {:<24} {:.4g}\n", one.text_or("name", "?"), one.number_or("value", 0.0));
  if (!alive && jobs.size() == 0 && can_go_on(status)) fmt::print("  go on with: {}\n", how_to_go_on(dir));
  return Exit::ok;
}

Result<Exit> stop(const fs::path& dir) {
  const bool alive = pilot::pilot_is_alive(dir);
  // A job that waits would go on where this one stops.
  bool any = false;
  for (const QueuedJob& job : queued_jobs(dir)) {
    if (job.state != "PENDING") continue;
    GRANARY_CHECK(cancel_job(job.id));
    fmt::print("{}: job {} was taken out of Slurm's queue\n", dir.string(), job.id);
    any = true;
  }
  if (any && !alive) return Exit::ok;
  GRANARY_TRY(const auto answer,
              pilot::ask_pilot(dir, json::Value::object({{"ask", "stop"}, {"reason", "stopped by the user"}})));
  fmt::print("{}: stopping; its tasks end gracefully. Go on later with: {}\n", dir.string(), how_to_go_on(dir));
  return Exit::ok;
}

Result<Exit> explain(const fs::path& dir, const std::string& task) {
  if (pilot::pilot_is_alive(dir)) {
    GRANARY_TRY(const auto answer, pilot::ask_pilot(dir, json::Value::object({{"ask", "explain"}, {"task", task}})));
    fmt::print("{}", answer.text_or("text", ""));
    return Exit::ok;
  }
  GRANARY_TRY(const auto past, past_of(dir));
  GRANARY_TRY(const std::string text, past->pilot->explain(task));
  fmt::print("{}", text);
  if (!past->pilot->idle()) fmt::print("No pilot is alive here. Go on with: {}\n", how_to_go_on(dir));
  return Exit::ok;
}

Result<Exit> report(const fs::path& dir, const fs::path& figures, const std::string& prefix) {
  const fs::path written = dir / "campaign.json";
  if (fs::exists(written)) {
    GRANARY_TRY(const json::Value document, json::read_file(written));
    if (document["understood"].text_or("kind", "") == "sweep") return report_sweep(dir, figures, prefix);
  }
  GRANARY_CHECK(report::write_report(dir / "results.h5", dir / "report.html"));
  if (!figures.empty()) GRANARY_CHECK(report::write_figures(dir / "results.h5", figures, prefix));
  fmt::print("{}\n", (dir / "report.html").string());
  return Exit::ok;
}

}  // namespace granary::commands
