#include "controller/commands/slurm_queue.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "pilot/launch/run_program.hpp"

namespace granary::commands {
namespace fs = std::filesystem;

namespace {

constexpr double kPatience = 60.0;  ///< with a busy controller [s]

/// In single quotes, as a shell reads it back.
std::string quoted(const std::string& text) {
  std::string safe = "'";
  for (const char c : text) safe += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return safe + "'";
}

/// Slurm counts in minutes, and takes hours, minutes and seconds.
std::string clock_time(double seconds) {
  const long s = std::lround(seconds);
  return fmt::format("{:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

std::vector<json::Value> jobs_of(const fs::path& dir) {
  std::error_code ignored;
  if (!fs::exists(dir / "jobs.jsonl", ignored)) return {};
  return json::read_lines(dir / "jobs.jsonl").value_or({});
}

}  // namespace

std::string batch_script(const campaign::Campaign& campaign, const fs::path& program, const fs::path& dir) {
  const campaign::Resources& resources = campaign.resources;
  std::string text = "#!/bin/bash\n";
  const auto ask = [&text](const std::string& option) { text += "#SBATCH " + option + "\n"; };
  ask("--job-name=" + campaign.name);
  ask(fmt::format("--nodes={}", resources.nodes));
  if (resources.exclusive) {
    ask("--exclusive");
    ask("--mem=0");
  } else {
    ask("--ntasks-per-node=1");
    ask(fmt::format("--cpus-per-task={}", resources.cores.value_or(1)));
  }
  if (!resources.partition.empty()) ask("--partition=" + resources.partition);
  if (!resources.account.empty()) ask("--account=" + resources.account);
  if (resources.walltime) ask("--time=" + clock_time(*resources.walltime));
  // The pilot is told in time, survives the loss of a node, and is never begun again by Slurm.
  ask(fmt::format("--signal=B:USR1@{}", std::lround(std::ceil(resources.stop_before))));
  ask("--no-kill");
  ask("--no-requeue");
  ask("--open-mode=append");
  for (const std::string& option : resources.options) ask(option);
  return text + fmt::format("exec {} resume {} --quiet\n", quoted(program.string()), quoted(dir.string()));
}

Result<std::string> submit_job(const campaign::Campaign& campaign, const fs::path& dir, bool chained) {
  GRANARY_CHECK(write_text_atomically(dir / "job.sh", batch_script(campaign, program_folder() / "granary", dir)));
  // --chdir: no path has to be fit for an #SBATCH line; Slurm's output file lies there, too.
  std::vector<std::string> argv{"sbatch", "--parsable", "--chdir=" + dir.string()};
  const char* ours = std::getenv("SLURM_JOB_ID");
  if (chained && ours != nullptr) argv.push_back(fmt::format("--dependency=afterany:{}", ours));
  argv.push_back((dir / "job.sh").string());
  GRANARY_TRY(const auto output, pilot::run_program(argv, "", kPatience));
  std::string id = output.out.substr(0, output.out.find_first_of(";\n"));
  const bool number = !id.empty() && std::all_of(id.begin(), id.end(), [](unsigned char c) { return std::isdigit(c); });
  if (output.exit_code != 0 || !number)
    return Error{fmt::format("sbatch refused {}: {}", (dir / "job.sh").string(), output.err)};
  GRANARY_TRY(auto jobs, json::LineWriter::append_to(dir / "jobs.jsonl"));
  GRANARY_CHECK(jobs.append(json::Value::object({{"job", id}, {"chained", chained}})));
  return id;
}

int n_chained_jobs(const fs::path& dir) {
  int count = 0;
  for (const json::Value& job : jobs_of(dir)) {
    const bool chained = job["chained"].is_bool() && job["chained"].as_bool();
    count = chained ? count + 1 : 0;
  }
  return count;
}

std::vector<QueuedJob> queued_jobs(const fs::path& dir) {
  std::string ids;
  for (const json::Value& job : jobs_of(dir)) ids += (ids.empty() ? "" : ",") + job.text_or("job", "");
  std::vector<QueuedJob> queued;
  if (ids.empty()) return queued;
  const auto output = pilot::run_program({"squeue", "-h", "-j", ids, "-o", "%i|%T|%r"}, "", kPatience);
  if (!output) return queued;
  std::istringstream lines(output->out);
  for (QueuedJob job;
       std::getline(lines, job.id, '|') && std::getline(lines, job.state, '|') && std::getline(lines, job.reason);)
    queued.push_back(job);
  return queued;
}

Status cancel_job(const std::string& id) {
  GRANARY_TRY(const auto output, pilot::run_program({"scancel", id}, "", kPatience));
  if (output.exit_code != 0) return Error{fmt::format("scancel {}: {}", id, output.err), Exit::internal};
  return {};
}

}  // namespace granary::commands
