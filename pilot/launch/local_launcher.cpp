#include "pilot/launch/local_launcher.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <optional>
#include <utility>

#include "common/files.hpp"
#include "common/log.hpp"
#include "pilot/launch/command.hpp"
#include "pilot/launch/marked.hpp"
#include "pilot/launch/prepared_processes.hpp"
#include "pilot/launch/set_aside.hpp"
#include "pilot/launch/spawn.hpp"

extern char** environ;

namespace granary::pilot {

namespace fs = std::filesystem;

namespace {

constexpr double kStrayPause = 0.005;  ///< between looks for processes that were sent SIGKILL [s]
constexpr int kStrayLooks = 400;
constexpr int kMostPrepared = 8;  ///< processes

std::vector<std::string> our_environment() {
  std::vector<std::string> env;
  for (char** entry = environ; *entry != nullptr; ++entry) env.emplace_back(*entry);
  return env;
}

/// Most output files lie in the working folder itself.
Status make_folder_of(const fs::path& file, const fs::path& dir) {
  return file.has_parent_path() ? make_folders((dir / file).parent_path()) : Status();
}

}  // namespace

struct LocalLauncher::State {
  struct Running {
    Launch launch;
    int pid = 0, pidfd = -1;
    std::shared_ptr<Child> child;
    bool killed = false, suspended = false;
    ProcessEnd end;  ///< once the first process has ended
    std::function<void(const RunEnd&)> ended;
  };

  RealLoop& loop;
  Machine machine;
  std::vector<std::string> environment = our_environment();
  std::vector<int> all_cpus;
  std::map<AttemptId, Running> running;
  PreparedProcesses prepared{std::min(machine.n_cores(), kMostPrepared)};

  /// The attempt, if its first process still lives.
  Running* living(AttemptId attempt) {
    const auto found = running.find(attempt);
    return found == running.end() || found->second.pidfd < 0 ? nullptr : &found->second;
  }

  std::vector<int> cpus_of(const CoreSet& cores) const {
    if (cores.empty()) return all_cpus;
    std::vector<int> cpus;
    cores.for_each([&](int core) { cpus.push_back(machine.cpu_of(core)); });
    return cpus;
  }

  void first_process_ended(AttemptId attempt) {
    Running& run = running.at(attempt);
    loop.unwatch(run.pidfd);
    // What it left running in its group goes with it; the group's number cannot be another's before the reaping.
    ::kill(-run.pid, SIGKILL);
    run.end = reap(run.pidfd);
    close(run.pidfd);
    run.pidfd = -1;
    const bool clean = !run.killed && run.end.exit_code == 0 && !uses_mpirun(run.launch.spec);
    if (clean) {
      finish(attempt);
    } else {
      finish_when_alone(attempt, kStrayLooks);
    }
  }

  /// A task has ended when its last process has: ranks and daemons are in groups of their own.
  void finish_when_alone(AttemptId attempt, int looks_left) {
    const Running& run = running.at(attempt);
    const std::vector<int> strays = marked_processes(run.launch.mark);
    for (const int pid : strays) ::kill(pid, SIGKILL);
    if (!strays.empty() && looks_left > 0) {
      loop.after(kStrayPause, [this, attempt, looks_left] { finish_when_alone(attempt, looks_left - 1); });
      return;
    }
    if (!strays.empty()) {
      log::warning("pilot", fmt::format("task {}: process {} does not end even after SIGKILL", run.launch.spec.name,
                                        strays.front()));
    }
    finish(attempt);
  }

  void finish(AttemptId attempt) {
    auto node = running.extract(attempt);
    Running& run = node.mapped();
    RunEnd end{run.end.exit_code, run.end.signal, run.end.cpu_s, {}, "", ""};
    if (const auto failure = start_failure(run.child)) end.not_started = failure->message;
    if (end.exit_code == 0) {
      std::error_code error;
      for (const fs::path& file : run.launch.spec.produces) {
        if (!fs::exists(run.launch.dir / file, error)) end.missing.push_back(file);
      }
    }
    run.ended(end);
  }
};

LocalLauncher::LocalLauncher(RealLoop& loop, Machine machine) : state_(new State{loop, std::move(machine)}) {
  for (int core = 0; core < state_->machine.n_cores(); ++core) state_->all_cpus.push_back(state_->machine.cpu_of(core));
}

LocalLauncher::~LocalLauncher() {
  for (auto& [attempt, run] : state_->running) {
    if (run.pidfd < 0) continue;
    state_->loop.unwatch(run.pidfd);
    ::kill(-run.pid, SIGKILL);
    signal_marked(run.launch.mark, SIGKILL);
    (void)reap(run.pidfd);
    close(run.pidfd);
  }
}

Result<ProcessKey> LocalLauncher::start(const Launch& launch, std::function<void(const RunEnd&)> ended) {
  SpawnRequest request;
  request.env = environment_of(launch, state_->environment);
  request.argv = launch.spec.command;
  if (access(launch.dir.c_str(), F_OK) != 0) GRANARY_CHECK(make_folders(launch.dir));
  if (uses_mpirun(launch.spec)) {
    // mpirun would report a missing program too, but with an exit code of its own and a page of text.
    GRANARY_TRY(const std::string checked,
                find_executable(launch.spec.command[0], launch.dir, variable(request.env, "PATH")));
    const fs::path rank_file = launch.dir / (launch.spec.name + ".ranks");
    GRANARY_CHECK(write_text_atomically(rank_file, rank_file_text(launch, state_->machine)));
    if (is_on_several_hosts(launch)) prepare_for_several_hosts(request.env);
    request.argv = mpirun_argv(launch, request.env, rank_file, geteuid() == 0);
  }
  GRANARY_TRY(request.file, find_executable(request.argv[0], launch.dir, variable(request.env, "PATH")));
  request.stdout_file = stdout_path(launch).string();
  request.stderr_file = stderr_path(launch).string();
  GRANARY_CHECK(make_folder_of(launch.spec.stdout_file, launch.dir));
  GRANARY_CHECK(make_folder_of(launch.spec.stderr_file, launch.dir));
  request.dir = launch.dir.string();
  request.cpus = state_->cpus_of(launch.cores);
  // The controller carries results over, monitors read and mpirun waits on the cores that fillers fill.
  request.background = launch.spec.fill;
  auto at_hand = state_->prepared.start(request);
  GRANARY_TRY(Spawned process, at_hand ? Result<Spawned>(std::move(*at_hand)) : spawn(request));

  const AttemptId attempt = launch.attempt;
  state_->running.emplace(
      attempt,
      State::Running{launch, process.pid, process.pidfd, std::move(process.child), false, false, {}, std::move(ended)});
  state_->loop.watch(process.pidfd, [state = state_.get(), attempt] { state->first_process_ended(attempt); });
  return ProcessKey{process.pid, process.start_ticks};
}

void LocalLauncher::signal(AttemptId attempt, int signal_number) {
  State::Running* run = state_->living(attempt);
  if (run == nullptr) return;
  ::kill(-run->pid, signal_number);
  if (!run->suspended) return;
  run->suspended = false;
  ::kill(-run->pid, SIGCONT);
  signal_marked(run->launch.mark, SIGCONT);
}

void LocalLauncher::kill(AttemptId attempt) {
  State::Running* run = state_->living(attempt);
  if (run == nullptr) return;
  run->killed = true;
  ::kill(-run->pid, SIGKILL);
  signal_marked(run->launch.mark, SIGKILL);
}

void LocalLauncher::suspend(AttemptId attempt) {
  State::Running* run = state_->living(attempt);
  if (run == nullptr) return;
  run->suspended = true;
  ::kill(-run->pid, SIGSTOP);
  signal_marked(run->launch.mark, SIGSTOP);  // ranks, in groups of their own
}

void LocalLauncher::resume(AttemptId attempt, const CoreSet& cores) {
  State::Running* run = state_->living(attempt);
  if (run == nullptr) return;
  run->suspended = false;
  if (!(cores == run->launch.cores)) {
    run->launch.cores = cores;
    pin_marked(run->launch.mark, state_->cpus_of(cores));
  }
  ::kill(-run->pid, SIGCONT);
  signal_marked(run->launch.mark, SIGCONT);
}

Status LocalLauncher::set_aside(const Launch& earlier, bool own_folder) {
  return set_aside_attempt(earlier, own_folder);
}

bool LocalLauncher::end_orphan(const ProcessKey& key, const std::string& mark) {
  bool any = false;
  if (key.pid > 0 && key.start_ticks != 0 && start_ticks(key.pid) == key.start_ticks) {
    ::kill(-key.pid, SIGKILL);
    any = true;
  }
  // Its ranks and daemons, and all of it if the pilot died before it could note the pid.
  if (end_processes_with(fmt::format("{}={}", kMarkVariable, mark) + '\0')) any = true;
  return any;
}

}  // namespace granary::pilot
