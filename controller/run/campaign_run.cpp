#include "controller/run/campaign_run.hpp"

#include <utility>

#include "common/log.hpp"

namespace granary::run {
using namespace coupling;

namespace {
constexpr const char* kEvent = "coupling.event";
constexpr const char* kDecision = "coupling.decision";

bool came_to_its_end(const State& state) { return state.ended == End::How::steady || state.ended == End::How::limit; }
}  // namespace

CampaignRun::CampaignRun(Settings settings, Handover& handover, pilot::Pilot& pilot, pilot::EventLoop& loop,
                         pilot::Journal& journal, Watcher watcher, Companion* companion)
    : settings_(settings),
      handover_(handover),
      pilot_(pilot),
      loop_(loop),
      journal_(journal),
      watcher_(std::move(watcher)),
      companion_(companion) {
  pilot_.on_end([this](const pilot::TaskEnd& end) { task_ended(end); });
}

Status CampaignRun::begin() {
  bool begun = false;
  for (const pilot::Record& record : journal_.records(kEvent)) {
    GRANARY_TRY(const Event event, event_from_json(record.payload));
    state_ = update(state_, event, settings_).next;
    begun = true;
  }
  if (begun) {
    // The tasks of the earlier life are gone; the coupling starts what it needs under new names.
    for (const std::string& name :
         {program_name(state_.burst, state_.attempt), monitor_name(state_.burst, state_.attempt)})
      if (const auto id = pilot_.find(name)) pilot_.stop(*id, "the campaign was resumed");
  }
  if (companion_ != nullptr) GRANARY_CHECK(companion_->begin(state_));
  if (came_to_its_end(state_))
    loop_.post([this] { finish(); });
  else
    later(begun ? Event(Resumed{}) : Event(Began{}));
  return {};
}

void CampaignRun::ask_stop(const std::string& message) {
  if (!finishing_) return later(StopAsked{message});
  finishing_ = false;
  cut_short_ = true;
  pilot_.stop_all(message);
}

Exit CampaignRun::exit() const {
  if (failure_) return failure_->exit;
  if (!state_.ended) return Exit::internal;
  if (cut_short_) return Exit::stopped;
  switch (*state_.ended) {
    case End::How::steady:
    case End::How::limit:
      return Exit::ok;
    case End::How::stopped:
      return Exit::stopped;
    case End::How::failed:
      return Exit::task_failed;
  }
  return Exit::internal;
}

// Events are never handled within an action: each is journalled, decided and acted on before the next.
void CampaignRun::later(Event event) {
  loop_.post([this, event = std::move(event)] { handle(event); });
}

void CampaignRun::handle(const Event& event) {
  if (failure_) return;
  Step step = update(state_, event, settings_);
  if (const Status written = journal_.append(kEvent, to_json(event)); !written) {
    failure_ = written.error();
    log::error("campaign", failure_->message);
    pilot_.stop_all(failure_->message);
    return;
  }
  state_ = std::move(step.next);
  watcher_.event(event);
  for (const Action& action : step.actions) {
    // What was decided is for people; the events alone rebuild it.
    if (const Status written = journal_.append(kDecision, to_json(action)); !written)
      log::warning("campaign", written.error().message);
    watcher_.action(action);
    act(action);
  }
  // Later: what the actions have begun comes first.
  if (companion_ != nullptr) loop_.post([this, event] { companion_->told(event, state_); });
}

void CampaignRun::act(const Action& action) {
  std::visit([this](const auto& each) { act_on(each); }, action);
}

void CampaignRun::act_on(const StartBurst& start) {
  const auto failed = [&](const Error& error) {
    TaskEnded ended;
    ended.burst = start.burst;
    ended.attempt = start.attempt;
    ended.outcome = TaskEnded::Outcome::failed;
    ended.message = error.message;
    later(ended);
  };
  auto tasks = handover_.prepare(start);
  if (!tasks) return failed(tasks.error());
  roles_[tasks->program.name] = {start.burst, start.attempt, false};
  if (tasks->monitor) roles_[tasks->monitor->name] = {start.burst, start.attempt, true};
  if (const auto submitted = pilot_.submit(tasks->program); !submitted) return failed(submitted.error());
  if (tasks->monitor) {
    if (const auto submitted = pilot_.submit(*tasks->monitor); !submitted)
      later(MonitorFailed{start.burst, start.attempt, submitted.error().message});
  }
  later(TaskStarted{start.burst, start.attempt});
}

void CampaignRun::act_on(const StopTask& stop) {
  if (const auto id = pilot_.find(program_name(stop.burst, stop.attempt))) pilot_.stop(*id, stop.why.message);
}

void CampaignRun::act_on(const AskMonitor& ask) {
  const std::string name = monitor_name(ask.burst, ask.attempt);
  const auto id = pilot_.find(name);
  if (id && roles_.count(name) > 0) {
    // It reads to the end of the file and says its last word; if it has ended, that is on its way to us already.
    if (!pilot_.end(*id)) pilot_.stop(*id, "its burst is over");
    return;
  }
  start_late_monitor(ask.burst, ask.attempt);
}

void CampaignRun::start_late_monitor(const BurstId& burst, int attempt) {
  const pilot::TaskSpec late = handover_.late_monitor(burst, attempt);
  roles_[late.name] = {burst, attempt, true};
  if (const auto submitted = pilot_.submit(late); !submitted)
    later(MonitorFailed{burst, attempt, submitted.error().message});
}

void CampaignRun::act_on(const coupling::Exchange& exchange) {
  const auto failed = [&](const Error& error) {
    later(ExchangeFailed{exchange.burst, exchange.attempt, error.message});
  };
  if (exchange.burst.kind == Kind::dem) {
    const auto summary = handover_.carry_dem(exchange);
    return summary ? later(DemExchanged{exchange.burst, exchange.attempt, *summary}) : failed(summary.error());
  }
  const auto summary = handover_.carry_pbm(exchange);
  return summary ? later(PbmExchanged{exchange.burst, exchange.attempt, *summary}) : failed(summary.error());
}

void CampaignRun::act_on(const End& end) {
  if (companion_ != nullptr && came_to_its_end(state_)) return finish();
  pilot_.stop_all(end.why.message);
}

void CampaignRun::finish() {
  if (companion_ == nullptr) return;
  finishing_ = true;
  companion_->finish(state_, [this] {
    if (!finishing_) return;
    finishing_ = false;
    pilot_.stop_all(state_.why_ended.message);
  });
}

void CampaignRun::task_ended(const pilot::TaskEnd& end) {
  const auto role = roles_.find(end.name);
  if (role == roles_.end()) {
    if (companion_ != nullptr) companion_->task_ended(end);
    return;
  }
  role->second.monitor ? monitor_ended(role->second, end) : program_ended(role->second, end);
}

void CampaignRun::program_ended(const Role& role, const pilot::TaskEnd& end) {
  constexpr int kDiverged = 20;
  TaskEnded ended;
  ended.burst = role.burst;
  ended.attempt = role.attempt;
  ended.time = handover_.clock(role.burst, end);
  if (end.exit_code == 0 && end.state == pilot::TaskState::stopped)
    ended.outcome = TaskEnded::Outcome::stopped;
  else if (end.state == pilot::TaskState::finished)
    ended.outcome = TaskEnded::Outcome::finished;
  else
    ended.outcome = end.exit_code == kDiverged ? TaskEnded::Outcome::diverged : TaskEnded::Outcome::failed;
  if (ended.outcome == TaskEnded::Outcome::failed || ended.outcome == TaskEnded::Outcome::diverged)
    ended.message = handover_.last_words(end);
  later(ended);
}

void CampaignRun::monitor_ended(const Role& role, const pilot::TaskEnd& end) {
  if (auto verdict = handover_.verdict(role.burst, end)) {
    later(MonitorSpoke{role.burst, role.attempt, *std::move(verdict)});
  } else if (state_.phase == Phase::closing && end.state == pilot::TaskState::stopped &&
             end.name == monitor_name(role.burst, role.attempt)) {
    start_late_monitor(role.burst, role.attempt);  // it hung when asked for its last word: another reads the same files
  } else {
    later(MonitorFailed{role.burst, role.attempt, verdict.error().message});
  }
}

}  // namespace granary::run
