#include "pilot/launch/simulated_launcher.hpp"

#include <csignal>
#include <utility>

namespace granary::pilot {

SimulatedLauncher::SimulatedLauncher(EventLoop& loop, std::function<SimulatedRun(const TaskSpec&)> model)
    : loop_(loop), model_(std::move(model)) {}

Result<ProcessKey> SimulatedLauncher::start(const Launch& launch, std::function<void(const RunEnd&)> ended) {
  if (free_places_.empty()) {
    free_places_.push_back(runs_.size());
    runs_.emplace_back();
  }
  Run& run = runs_[free_places_.back()];
  place_of_.emplace(launch.attempt, free_places_.back());
  free_places_.pop_back();
  run = Run();
  run.attempt = launch.attempt;
  run.plan = model_(launch.spec);
  run.cores = launch.cores.size();
  run.left = run.plan.seconds;
  run.since = loop_.now();
  run.exit_code = run.plan.exit_code;
  run.ended = std::move(ended);
  arm(run);
  return ProcessKey{};
}

/// nullptr: it does not run (any more).
SimulatedLauncher::Run* SimulatedLauncher::find(AttemptId attempt) {
  const auto found = place_of_.find(attempt);
  return found == place_of_.end() ? nullptr : &runs_[found->second];
}

/// Books the running time up to now.
void SimulatedLauncher::settle(Run& run) {
  const double ran = run.suspended ? 0.0 : loop_.now() - run.since;
  run.left -= ran;
  run.cpu_s += ran * run.cores;
  run.since = loop_.now();
}

void SimulatedLauncher::arm(Run& run) {
  loop_.cancel(run.timer);
  run.timer = loop_.after(run.left, [this, place = static_cast<std::size_t>(&run - runs_.data())] { end(place); });
}

void SimulatedLauncher::end(std::size_t place) {
  Run run = std::move(runs_[place]);  // what is told of its end may start the next one
  place_of_.erase(run.attempt);
  free_places_.push_back(place);
  settle(run);
  if (run.plan.at_end) run.plan.at_end();
  RunEnd end;
  end.exit_code = run.exit_code;
  end.signal = run.signal;
  end.cpu_s = run.cpu_s;
  run.ended(end);
}

void SimulatedLauncher::signal(AttemptId attempt, int signal_number) {
  Run* run = find(attempt);
  if (run == nullptr) return;
  settle(*run);
  run->suspended = false;
  if (signal_number == SIGKILL) return kill(attempt);
  if (!run->plan.ignores_stop && run->plan.stop_after < run->left) {
    run->left = run->plan.stop_after;
    run->exit_code = run->plan.stop_exit_code;
  }
  arm(*run);
}

void SimulatedLauncher::kill(AttemptId attempt) {
  Run* run = find(attempt);
  if (run == nullptr) return;
  settle(*run);
  run->suspended = false;
  run->left = 0.0;
  run->exit_code = -1;
  run->signal = SIGKILL;
  arm(*run);
}

void SimulatedLauncher::suspend(AttemptId attempt) {
  Run* run = find(attempt);
  if (run == nullptr) return;
  settle(*run);
  run->suspended = true;
  loop_.cancel(run->timer);
}

void SimulatedLauncher::resume(AttemptId attempt, const CoreSet&) {
  Run* run = find(attempt);
  if (run == nullptr) return;
  settle(*run);
  run->suspended = false;
  arm(*run);
}

Status SimulatedLauncher::set_aside(const Launch&, bool) { return {}; }

bool SimulatedLauncher::end_orphan(const ProcessKey&, const std::string&) { return false; }

}  // namespace granary::pilot
