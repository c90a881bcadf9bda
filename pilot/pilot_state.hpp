// What a pilot is made of, and its turn: events, then decisions, then one write, then actions. Only for pilot/*.cpp.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/json/text.hpp"
#include "common/log.hpp"
#include "pilot/pilot.hpp"
#include "pilot/schedule/scheduler.hpp"
#include "pilot/summary.hpp"
#include "pilot/task/update.hpp"

namespace granary::pilot {

struct Pilot::State {
  State(PilotOptions o, EventLoop& l, Launcher& la, Journal& j)
      : options(std::move(o)),
        loop(l),
        launcher(la),
        journal(j),
        scheduler(table, options.machine),
        loop_start(l.now()) {}

  PilotOptions options;
  EventLoop& loop;
  Launcher& launcher;
  Journal& journal;
  Table table;
  Scheduler scheduler;
  std::string run_id;                                         ///< of the campaign: what its processes are marked with
  double loop_start;                                          ///< loop's clock at ...
  double time_base = 0.0;                                     ///< ... this pilot time [s]
  double deadline = std::numeric_limits<double>::infinity();  ///< pilot time of the allocation's end [s]
  bool stopping = false;
  std::string stop_reason;
  json::Value opening;  ///< the record of it
  bool turn_posted = false;
  std::vector<Action> todo;  ///< once the journal has what led to it
  std::string text;          ///< of the record being written
  Launch launch;             ///< of the attempt being started
  std::vector<TaskId> ends_to_tell;
  bool idle_told = true;
  bool sync_set = false;
  std::optional<Error> failure;
  std::map<AttemptId, std::array<TimerId, 2>> alarms;
  std::map<std::filesystem::path, int> folders;  ///< how many tasks work in each but the campaign's own
  std::vector<std::function<void(const TaskEnd&)>> end_callbacks;
  std::vector<std::function<void()>> idle_callbacks;
  std::shared_ptr<bool> alive = std::make_shared<bool>(true);  ///< posted calls find out whether we still are

  double now() const { return time_base + loop.now() - loop_start; }

  std::filesystem::path folder_of(const TaskSpec& spec) const {
    return spec.dir.empty() ? options.dir : options.dir / spec.dir;
  }

  void post(void (State::*member)()) {
    loop.post([this, member, watch = std::weak_ptr<bool>(alive)] {
      if (!watch.expired()) (this->*member)();
    });
  }

  // --- events: journal, then update, then act ---
  // One turn of the loop takes up what has happened, decides, writes all of that with one write, and only then acts.

  void record(std::string_view kind, const json::Value& payload) {
    text.clear();
    json::append(text, payload);
    journal.add(kind, text);
  }
  void record(const Event& event) {
    text.clear();
    append(text, event);
    journal.add(kind_of(event), text);
  }

  /// Both what we decide to do and what has happened in the world; what follows from it is done by the turn, once it is
  /// written.
  void happens(Event event) {
    record(event);
    update(table, std::move(event), todo);
    turn_soon();
  }

  /// Error: the journal could not take it, or will not take much more.
  Status flush() {
    const Status written = journal.flush();
    if (!written) fail(written.error());
    if (written && !journal.healthy()) fail(journal.healthy().error());
    if (journal.dirty()) sync_soon();
    return written;
  }

  void sync_soon() {
    if (sync_set || options.sync_every <= 0.0) return;
    sync_set = true;
    loop.after(options.sync_every, [this, watch = std::weak_ptr<bool>(alive)] {
      if (watch.expired()) return;
      (void)flush();
      if (const Status synced = journal.sync_beside(); !synced) fail(synced.error());
      sync_set = false;
      if (journal.dirty()) sync_soon();  // the disk is slower than we ask it
    });
  }

  void turn_soon() {
    if (turn_posted) return;
    turn_posted = true;
    post(&State::turn);
  }

  void turn() {
    if (!stopping) {
      for (Decision& decision : scheduler.decide(now(), deadline))
        std::visit([this](auto& what) { carry_out(what); }, decision);
      end_early_if_nothing_fits();
    }
    const bool written = flush().has_value();
    turn_posted = false;  // what the actions bring about is for the next turn
    for (const Action& action : std::exchange(todo, {})) {
      if (const auto* spawn = std::get_if<Spawn>(&action); spawn != nullptr && !written) {
        happens({now(), Lost{spawn->attempt, "it was not started: the journal cannot be written"}});
      } else {
        std::visit([this](const auto& what) { act(what); }, action);
      }
    }
    if (idle() && !idle_told) {
      idle_told = true;
      post(&State::tell_idle);
    }
  }

  // --- actions ---

  /// Valid until the next call: the room of its texts and lists is used again.
  const Launch& launch_of(const Task& task, const Attempt& attempt) {
    launch.attempt = {task.id, attempt.number};
    launch.spec = task.spec;
    launch.dir = options.dir;
    if (!task.spec.dir.empty()) launch.dir /= task.spec.dir;
    launch.cores = attempt.pieces.back().cores;
    launch.mark = mark_of(launch.attempt);
    return launch;
  }

  std::string mark_of(AttemptId attempt) const {
    return fmt::format("{}.{}.{}", run_id, attempt.task.value, attempt.number);
  }

  void count_folder(const TaskSpec& spec) {
    if (!spec.dir.empty()) ++folders[folder_of(spec)];
  }

  /// Whether no other task works in the task's folder or below it.
  bool owns_folder(const Task& task) const {
    const std::filesystem::path folder = folder_of(task.spec);
    if (folder == options.dir) return false;
    const auto found = folders.find(folder);
    if (found == folders.end() || found->second > 1) return false;
    const auto next = std::next(found);
    return next == folders.end() || !next->first.string().starts_with(folder.string() + "/");
  }

  void act(const Spawn& spawn) {
    const Task& task = table.at(spawn.attempt.task);
    if (const Status kept = keep_earlier_attempt(task); !kept) {
      return happens({now(), StartFailed{spawn.attempt, kept.error().message}});
    }
    const auto started = launcher.start(
        launch_of(task, task.last()), [this, attempt = spawn.attempt](const RunEnd& end) { run_ended(attempt, end); });
    if (started) {
      // Nothing follows from it, so it may wait for the next write; after a kill the mark finds the process without it.
      Event event{now(), Started{spawn.attempt, started->pid, started->start_ticks}};
      record(event);
      update(table, std::move(event), todo);
      sync_soon();
    } else {
      happens({now(), StartFailed{spawn.attempt, started.error().message}});
    }
  }

  void run_ended(AttemptId attempt, const RunEnd& end) {
    if (!end.lost.empty()) return happens({now(), Lost{attempt, end.lost}});
    if (!end.not_started.empty()) return happens({now(), StartFailed{attempt, end.not_started}});
    happens({now(), Exited{attempt, end.exit_code, end.signal, end.cpu_s, end.missing}});
  }

  Status keep_earlier_attempt(const Task& task) {
    if (task.attempts.size() < 2) return {};
    Launch earlier = launch_of(task, task.attempts[task.attempts.size() - 2]);
    // What goes on where it was finds its files in their places; only its output is kept apart.
    if (task.spec.resumable) earlier.spec.produces.clear();
    return launcher.set_aside(earlier, !task.spec.resumable && owns_folder(task));
  }

  void act(const AskToEnd& ask) { launcher.signal(ask.attempt, ask.signal); }
  void act(const Kill& kill) { launcher.kill(kill.attempt); }
  void act(const Pause& pause) { launcher.suspend(pause.attempt); }
  void act(const Continue& go_on) {
    launcher.resume(go_on.attempt, table.at(go_on.attempt.task).last().pieces.back().cores);
  }

  void act(const SetAlarm& set) {
    TimerId& timer = alarms[set.attempt][static_cast<std::size_t>(set.alarm)];
    loop.cancel(timer);
    timer = loop.after(set.after, [this, set, watch = std::weak_ptr<bool>(alive)] {
      if (watch.expired()) return;
      if (set.alarm == Alarm::timeout) {
        happens({now(), TimedOut{set.attempt}});
      } else {
        happens({now(), GraceOver{set.attempt}});
      }
    });
  }

  void act(const ClearAlarm& clear) {
    const auto found = alarms.find(clear.attempt);
    if (found == alarms.end()) return;
    TimerId& timer = found->second[static_cast<std::size_t>(clear.alarm)];
    loop.cancel(timer);
    timer = TimerId::none;
    if (found->second[0] == TimerId::none && found->second[1] == TimerId::none) alarms.erase(found);
  }

  void act(const Report& report) {
    if (ends_to_tell.empty()) post(&State::tell_ends);
    ends_to_tell.push_back(report.id);
  }

  void tell_ends() {
    const std::weak_ptr<bool> watch = alive;
    for (const TaskId id : std::exchange(ends_to_tell, {})) {
      if (watch.expired()) return;
      const TaskEnd end = end_of(table.at(id), folder_of(table.at(id).spec));
      for (std::size_t k = 0; !watch.expired() && k < end_callbacks.size(); ++k) end_callbacks[k](end);
    }
  }

  // --- scheduling ---

  /// When nothing runs and what is ready would run beyond the allocation's end, waiting for it helps nobody.
  void end_early_if_nothing_fits() {
    if (stopping || !table.running_ids.empty() || !table.suspended.empty() || !scheduler.only_late_ones_left()) return;
    stopping = true;
    stop_reason = "none of the tasks left can end before the allocation does";
    log::info("pilot", stop_reason);
    stop_active();
  }

  void tell_idle() {
    // Callbacks of the last task's end may have submitted more meanwhile.
    if (!idle()) {
      idle_told = false;
      return;
    }
    const std::weak_ptr<bool> watch = alive;
    for (std::size_t k = 0; k < idle_callbacks.size() && !watch.expired(); ++k) idle_callbacks[k]();
  }

  void carry_out(StartTask& start) {
    happens({now(), Placed{{start.id, table.at(start.id).attempt_id().number + 1}, std::move(start.cores)}});
  }
  void carry_out(const SuspendFiller& suspend) { happens({now(), Suspended{table.at(suspend.id).attempt_id()}}); }
  void carry_out(const KillFiller& kill) { happens({now(), Preempted{table.at(kill.id).attempt_id()}}); }
  void carry_out(const ResumeFiller& resume) {
    happens({now(), Resumed{table.at(resume.id).attempt_id(), resume.cores}});
  }

  bool idle() const {
    const bool nothing_runs = table.running_ids.empty() && table.suspended.empty();
    return nothing_runs && (stopping || (table.n_waiting == 0 && table.n_ready == 0));
  }

  // --- nodes ---

  /// The attempts with a core on a node, and whether they have some elsewhere.
  std::vector<std::pair<AttemptId, bool>> attempts_on(int node) const {
    std::vector<std::pair<AttemptId, bool>> attempts;
    for (const TaskId id : active_tasks()) {
      int there = 0, elsewhere = 0;
      table.at(id).last().pieces.back().cores.for_each(
          [&](int core) { ++(scheduler.resources().node_of(core) == node ? there : elsewhere); });
      if (there > 0) attempts.emplace_back(table.at(id).attempt_id(), elsewhere > 0);
    }
    return attempts;
  }

  void lose_node(int node, const std::string& reason) {
    if (node < 0 || node >= scheduler.resources().n_nodes() || !scheduler.resources().is_up(node)) return;
    const std::string& name = options.machine.nodes[static_cast<std::size_t>(node)].name;
    turn_soon();
    record("node.lost", json::Value::object({{"time_s", now()}, {"node", node}, {"name", name}, {"reason", reason}}));
    scheduler.lose_node(node);
    const std::string why = fmt::format("node {} was lost: {}", name, reason);
    for (const auto& [attempt, elsewhere] : attempts_on(node)) {
      const Ending ending = table.at(attempt.task).ending;
      if (elsewhere && ending != Ending::stop && ending != Ending::stop_resumable) {
        happens({now(), Abandoned{attempt, why}});
      } else {
        launcher.kill(attempt);
        happens({now(), Lost{attempt, why}});
      }
    }
    turn_soon();
  }

  void regain_node(int node) {
    if (node < 0 || node >= scheduler.resources().n_nodes() || scheduler.resources().is_up(node)) return;
    const std::string& name = options.machine.nodes[static_cast<std::size_t>(node)].name;
    turn_soon();
    record("node.back", json::Value::object({{"time_s", now()}, {"node", node}, {"name", name}}));
    scheduler.regain_node(node);
    turn_soon();
  }

  // --- stopping ---

  /// The journal cannot be written: nothing more is started, what runs is asked to end as soon as the current event is
  /// done.
  void fail(const Error& error) {
    if (failure) return;
    failure = error;
    log::error("pilot", error.message);
    stopping = true;
    stop_reason = error.message;
    post(&State::stop_active);
  }

  void stop_active() {
    for (const TaskId id : active_tasks()) happens({now(), StopAsked{id, stop_reason, true}});
    idle_told = false;
    turn_soon();
  }

  std::vector<TaskId> active_tasks() const {
    std::vector<TaskId> active = table.running();
    for (const Turn& turn : table.suspended) active.push_back(turn.id);
    return active;
  }

  // --- the beginning: opening.cpp ---

  Status replay(const Line& line);
  Status replay();
  bool belongs_here(const Event& event, TaskId id) const;
  Status begin();
  /// Ends the orphans of the last pilot and queues their tasks again, and those that it had stopped itself.
  void take_up();
  Status compact();
};

}  // namespace granary::pilot
