// A pilot of its own for the tests that kill it, and for timing it: pilot_host DIR TASKS.json [CORES].
// Runs the list to its end (or resumes it) and prints its summary; ends with the summary's exit code.
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "common/json/io.hpp"
#include "pilot/control/control.hpp"
#include "pilot/control/run_lock.hpp"
#include "pilot/launch/local_launcher.hpp"
#include "pilot/schedule/check_tasks.hpp"
#include "pilot/task/spec_json.hpp"
#include "pilot/task_list.hpp"

namespace {

using namespace granary;
using namespace granary::pilot;

Result<std::vector<TaskSpec>> read_tasks(const char* file, const Machine& machine) {
  GRANARY_TRY(const json::Value document, json::read_file(file));
  json::Problems problems;
  json::Reader reader(document, file, problems);
  std::vector<TaskSpec> tasks;
  for (json::Reader& task : reader.items("tasks")) tasks.push_back(read_task(task));
  reader.done();
  check_tasks(tasks, machine, file, problems);
  if (!problems.empty()) return problems.error();
  return tasks;
}

/// Kills this process with the n-th start of a task, before or after it: PILOT_HOST_DIE=before:3.
class DyingLauncher final : public Launcher {
 public:
  explicit DyingLauncher(Launcher& real) : real_(real) {
    const char* when = std::getenv("PILOT_HOST_DIE");
    if (when == nullptr) return;
    before_ = std::string(when).starts_with("before:");
    left_ = std::atoi(std::string(when).substr(std::string(when).find(':') + 1).c_str());
  }
  Result<ProcessKey> start(const Launch& launch, std::function<void(const RunEnd&)> ended) override {
    const bool now = --left_ == 0;
    if (now && before_) raise(SIGKILL);
    auto key = real_.start(launch, std::move(ended));
    if (now) raise(SIGKILL);
    return key;
  }
  void signal(AttemptId attempt, int signal_number) override { real_.signal(attempt, signal_number); }
  void kill(AttemptId attempt) override { real_.kill(attempt); }
  void suspend(AttemptId attempt) override { real_.suspend(attempt); }
  void resume(AttemptId attempt, const CoreSet& cores) override { real_.resume(attempt, cores); }
  Status set_aside(const Launch& earlier, bool own_folder) override { return real_.set_aside(earlier, own_folder); }
  bool end_orphan(const ProcessKey& key, const std::string& mark) override { return real_.end_orphan(key, mark); }

 private:
  Launcher& real_;
  bool before_ = false;
  int left_ = 0;
};

Result<TaskListSummary> run(const std::filesystem::path& dir, const char* file, int cores) {
  GRANARY_TRY(const Machine machine, local_machine(cores));
  GRANARY_TRY(const std::vector<TaskSpec> tasks, read_tasks(file, machine));
  GRANARY_TRY(const RunLock lock, RunLock::take(dir));
  GRANARY_TRY(Journal journal, Journal::open(dir / "journal.jsonl"));
  RealLoop loop;
  LocalLauncher real(loop, machine);
  DyingLauncher launcher(real);
  GRANARY_TRY(const std::unique_ptr<Pilot> pilot, Pilot::open({dir, machine}, loop, launcher, journal));
  GRANARY_TRY(const ControlServer control,
              ControlServer::listen(loop, dir, [&](const json::Value& request) { return pilot->answer(request); }));
  loop.on_signals({SIGINT, SIGTERM},
                  [&](int signal) { pilot->stop_all(signal == SIGINT ? "interrupted" : "terminated"); });
  return run_task_list(tasks, *pilot, loop);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return std::fprintf(stderr, "usage: pilot_host DIR TASKS.json [CORES]\n"), 2;
  const auto summary = run(argv[1], argv[2], argc > 3 ? std::atoi(argv[3]) : 0);
  if (!summary) {
    std::fprintf(stderr, "%s\n", summary.error().message.c_str());
    return static_cast<int>(summary.error().exit);
  }
  std::printf("%s\n", json::dump(summary->json()).c_str());
  return static_cast<int>(summary->exit);
}
