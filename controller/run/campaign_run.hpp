// Joins the coupling to the pilot: what happens to tasks becomes events, the state machine's actions become tasks.
// Every event is journalled before it is acted on; a resume replays them. Real and dry runs are the same code.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "controller/coupling/update.hpp"
#include "controller/run/companion.hpp"
#include "controller/run/handover.hpp"
#include "pilot/pilot.hpp"

namespace granary::run {

/// What a watcher is told; each call comes after the journal has it.
struct Watcher {
  std::function<void(const coupling::Event&)> event = [](const coupling::Event&) {};
  std::function<void(const coupling::Action&)> action = [](const coupling::Action&) {};
  std::function<void(const std::string&)> note = [](const std::string&) {};  ///< a line for people
};

class CampaignRun {
 public:
  /// All must outlive the run. The pilot's on_end is taken. `companion` may be none.
  CampaignRun(coupling::Settings settings, Handover& handover, pilot::Pilot& pilot, pilot::EventLoop& loop,
              pilot::Journal& journal, Watcher watcher = {}, Companion* companion = nullptr);

  /// Begins, or goes on where the journal ends. Then the loop drives everything.
  Status begin();
  /// A graceful, resumable end.
  void ask_stop(const std::string& message);

  const coupling::State& state() const { return state_; }
  /// The coupling is over, and its companion is done.
  bool ended() const { return state_.phase == coupling::Phase::ended && !finishing_; }
  /// ok (steady, limit) | stopped | task_failed; internal while it has not ended.
  Exit exit() const;
  /// The journal cannot be written any more (a full disk): the run was stopped.
  const std::optional<Error>& failure() const { return failure_; }

 private:
  struct Role {
    coupling::BurstId burst;
    int attempt = 1;
    bool monitor = false;
  };

  void handle(const coupling::Event& event);
  void later(coupling::Event event);
  void act(const coupling::Action& action);
  void act_on(const coupling::StartBurst& start);
  void act_on(const coupling::StopTask& stop);
  void act_on(const coupling::AskMonitor& ask);
  void start_late_monitor(const coupling::BurstId& burst, int attempt);
  void act_on(const coupling::Exchange& exchange);
  void act_on(const coupling::End& end);
  void finish();
  void task_ended(const pilot::TaskEnd& end);
  void program_ended(const Role& role, const pilot::TaskEnd& end);
  void monitor_ended(const Role& role, const pilot::TaskEnd& end);

  coupling::Settings settings_;
  Handover& handover_;
  pilot::Pilot& pilot_;
  pilot::EventLoop& loop_;
  pilot::Journal& journal_;
  Watcher watcher_;
  Companion* companion_;
  coupling::State state_;
  std::map<std::string, Role> roles_;  ///< by task name, of the tasks of this life
  bool finishing_ = false;             ///< the coupling is over, its companion is not
  bool cut_short_ = false;             ///< the companion was stopped before it was done
  std::optional<Error> failure_;
};

}  // namespace granary::run
