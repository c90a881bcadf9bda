#include "controller/estimation/estimation_run.hpp"

#include <utility>

namespace granary::estimating {

EstimationRun::EstimationRun(Crew& crew, pilot::Pilot& pilot, pilot::EventLoop& loop, std::function<void()> changed)
    : crew_(crew), pilot_(pilot), loop_(loop), changed_(std::move(changed)) {
  pilot_.on_end([this](const pilot::TaskEnd& end) { task_ended(end); });
  pilot_.on_idle([this] { loop_.stop(); });
}

Status EstimationRun::begin() {
  submit();
  // Nothing may have been left to do, and then nothing ever becomes idle.
  loop_.post([this] {
    if (pilot_.idle()) loop_.stop();
  });
  return failure_ ? Status(*failure_) : Status{};
}

void EstimationRun::submit() {
  if (pilot_.stopping()) return;
  if (crew_.done()) return pilot_.stop_all("everything is known");
  auto tasks = crew_.next();
  if (!tasks) return fail(tasks.error());
  for (pilot::TaskSpec& task : *tasks)
    if (const auto submitted = pilot_.submit(std::move(task)); !submitted) return fail(submitted.error());
  if (crew_.done()) pilot_.stop_all("everything is known");
}

void EstimationRun::task_ended(const pilot::TaskEnd& end) {
  if (failure_) return;
  if (const Status taken = crew_.ended(end); !taken) return fail(taken.error());
  changed_();
  submit();
}

void EstimationRun::fail(const Error& error) {
  failure_ = error;
  pilot_.stop_all(error.message);
}

}  // namespace granary::estimating
