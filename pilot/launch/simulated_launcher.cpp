#include "pilot/launch/simulated_launcher.hpp"

#include <csignal>

namespace granary::pilot {

SimulatedLauncher::SimulatedLauncher(EventLoop& loop, std::function<SimulatedRun(const TaskSpec&)> model)
    : loop_(loop), model_(std::move(model)) {}

Result<ProcessKey> SimulatedLauncher::start(const Launch& launch, std::function<void(const RunEnd&)> ended) {
  Run& run = runs_[launch.attempt];
  run.plan = model_(launch.spec);
  run.cores = launch.cores.size();
  run.left = run.plan.seconds;
  run.since = loop_.now();
  run.exit_code = run.plan.exit_code;
  run.ended = std::move(ended);
  arm(launch.attempt, run);
  return ProcessKey{};
}

/// Books the running time up to now.
void SimulatedLauncher::settle(Run& run) {
  const double ran = run.suspended ? 0.0 : loop_.now() - run.since;
  run.left -= ran;
  run.cpu_s += ran * run.cores;
  run.since = loop_.now();
}

void SimulatedLauncher::arm(AttemptId attempt, Run& run) {
  loop_.cancel(run.timer);
  run.timer = loop_.after(run.left, [this, attempt] { end(attempt); });
}

void SimulatedLauncher::end(AttemptId attempt) {
  auto node = runs_.extract(attempt);
  Run& run = node.mapped();
  settle(run);
  if (run.plan.at_end) run.plan.at_end();
  RunEnd end;
  end.exit_code = run.exit_code;
  end.signal = run.signal;
  end.cpu_s = run.cpu_s;
  run.ended(end);
}

void SimulatedLauncher::signal(AttemptId attempt, int signal_number) {
  const auto found = runs_.find(attempt);
  if (found == runs_.end()) return;
  Run& run = found->second;
  settle(run);
  run.suspended = false;
  if (signal_number == SIGKILL) return kill(attempt);
  if (!run.plan.ignores_stop && run.plan.stop_after < run.left) {
    run.left = run.plan.stop_after;
    run.exit_code = run.plan.stop_exit_code;
  }
  arm(attempt, run);
}

void SimulatedLauncher::kill(AttemptId attempt) {
  const auto found = runs_.find(attempt);
  if (found == runs_.end()) return;
  Run& run = found->second;
  settle(run);
  run.suspended = false;
  run.left = 0.0;
  run.exit_code = -1;
  run.signal = SIGKILL;
  arm(attempt, run);
}

void SimulatedLauncher::suspend(AttemptId attempt) {
  const auto found = runs_.find(attempt);
  if (found == runs_.end()) return;
  settle(found->second);
  found->second.suspended = true;
  loop_.cancel(found->second.timer);
}

void SimulatedLauncher::resume(AttemptId attempt, const CoreSet&) {
  const auto found = runs_.find(attempt);
  if (found == runs_.end()) return;
  settle(found->second);
  found->second.suspended = false;
  arm(attempt, found->second);
}

Status SimulatedLauncher::set_aside(const Launch&, bool) { return {}; }

bool SimulatedLauncher::end_orphan(const ProcessKey&, const std::string&) { return false; }

}  // namespace granary::pilot
