#include "controller/estimation/estimation_run.hpp"

#include <fmt/format.h>

#include <utility>

namespace granary::estimating {

EstimationRun::EstimationRun(Crew& crew, pilot::Pilot& pilot, pilot::EventLoop& loop, std::function<void()> changed,
                             std::function<Result<Tasks>()> last)
    : crew_(crew), pilot_(pilot), loop_(loop), changed_(std::move(changed)), last_(std::move(last)) {
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
  if (pilot_.stopping() || ending_) return;
  if (crew_.done()) return end();
  auto tasks = crew_.next();
  if (!tasks) return fail(tasks.error());
  for (pilot::TaskSpec& task : *tasks)
    if (const auto submitted = pilot_.submit(std::move(task)); !submitted) return fail(submitted.error());
  if (crew_.done()) end();
}

void EstimationRun::end() {
  ending_ = true;
  for (const std::string& name : crew_.open())
    if (const auto id = pilot_.find(name)) pilot_.stop(*id, "everything is known");
  auto tasks = last_();
  if (!tasks) return fail(tasks.error());
  for (const pilot::TaskSpec& task : *tasks) last_names_.insert(task.name);
  for (pilot::TaskSpec& task : *tasks)
    if (const auto submitted = pilot_.submit(std::move(task)); !submitted) return fail(submitted.error());
}

void EstimationRun::task_ended(const pilot::TaskEnd& end) {
  if (failure_) return;
  if (last_names_.count(end.name) != 0) {
    if (end.state == pilot::TaskState::finished)
      last_names_.erase(end.name);
    else if (!pilot_.stopping())
      fail({fmt::format("{}: the run with the estimate failed: {}; see {}", end.name, end.reason, end.dir.string()),
            Exit::task_failed});
    return;
  }
  if (const Status taken = crew_.ended(end); !taken) return fail(taken.error());
  changed_();
  submit();
}

void EstimationRun::fail(const Error& error) {
  failure_ = error;
  pilot_.stop_all(error.message);
}

}  // namespace granary::estimating
