#include "controller/run/simulated_estimation.hpp"

#include <fmt/format.h>

namespace granary::run {

/// From the first rates on there is work, and as much of it as cores fall idle.
void SimulatedEstimation::told(const coupling::Event& event, const coupling::State& state) {
  const auto* started = std::get_if<coupling::TaskStarted>(&event);
  if (state.ended || started == nullptr || submitted_ > 0) return;
  if (started->burst.kind == coupling::Kind::dem) loop_.after(first_rates_, [this] { submit(); });
}

void SimulatedEstimation::submit() {
  const int cores = pilot_.machine().n_cores();
  while (!over_ && open_ < cores + 1 + cores / 8) {
    pilot::TaskSpec task;
    task.name = fmt::format("estimate-{:06}", ++submitted_);
    task.command = {"granary-pbm", "evaluate"};
    task.fill = true;
    if (!pilot_.submit(std::move(task))) return;
    ++open_;
  }
}

void SimulatedEstimation::task_ended(const pilot::TaskEnd&) {
  --open_;
  if (!pilot_.stopping()) submit();
}

void SimulatedEstimation::finish(const coupling::State&, std::function<void()> done) {
  over_ = true;
  done();
}

}  // namespace granary::run
