#include "pilot/pilot.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <random>

#include "common/json/problems.hpp"
#include "common/log.hpp"
#include "common/version.hpp"
#include "pilot/journal/text.hpp"
#include "pilot/schedule/check_tasks.hpp"
#include "pilot/schedule/explain.hpp"
#include "pilot/schedule/scheduler.hpp"
#include "pilot/summary.hpp"
#include "pilot/task/spec_json.hpp"
#include "pilot/task/update.hpp"

namespace granary::pilot {

namespace fs = std::filesystem;

namespace {

std::string new_run_id() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", random(), random());
}

}  // namespace

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
  bool idle_told = true;
  bool sync_set = false;
  std::optional<Error> failure;
  std::map<AttemptId, std::array<TimerId, 2>> alarms;
  std::map<fs::path, int> folders;  ///< how many tasks work in each
  std::vector<std::function<void(const TaskEnd&)>> end_callbacks;
  std::vector<std::function<void()>> idle_callbacks;
  std::shared_ptr<bool> alive = std::make_shared<bool>(true);  ///< posted calls find out whether we still are

  double now() const { return time_base + loop.now() - loop_start; }

  fs::path folder_of(const TaskSpec& spec) const { return spec.dir.empty() ? options.dir : options.dir / spec.dir; }

  void post(void (State::*member)()) {
    loop.post([this, member, watch = std::weak_ptr<bool>(alive)] {
      if (!watch.expired()) (this->*member)();
    });
  }

  // --- events: journal, then update, then act ---
  // One turn of the loop takes up what has happened, decides, writes all of that with one write, and only then acts.

  void record(const std::string& kind, const json::Value& payload) {
    text.clear();
    append_json(text, payload);
    journal.add(kind, text);
  }

  /// Both what we decide to do and what has happened in the world; what follows from it is done by the turn, once it is
  /// written.
  void happens(const Event& event) {
    record(kind_of(event), to_json(event));
    update(table, event, todo);
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
      if (const Status synced = journal.sync(); !synced) fail(synced.error());
      sync_set = false;
    });
  }

  void turn_soon() {
    if (turn_posted) return;
    turn_posted = true;
    post(&State::turn);
  }

  void turn() {
    if (!stopping) {
      for (const Decision& decision : scheduler.decide(now(), deadline))
        std::visit([this](const auto& what) { carry_out(what); }, decision);
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

  Launch launch_of(const Task& task, const Attempt& attempt) const {
    return {{task.id, attempt.number},
            task.spec,
            folder_of(task.spec),
            attempt.pieces.back().cores.list(),
            mark_of({task.id, attempt.number})};
  }

  std::string mark_of(AttemptId attempt) const {
    return fmt::format("{}.{}.{}", run_id, attempt.task.value, attempt.number);
  }

  /// Whether no other task works in the task's folder or below it.
  bool owns_folder(const Task& task) const {
    const fs::path folder = folder_of(task.spec);
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
      const Event event{now(), Started{spawn.attempt, started->pid, started->start_ticks}};
      record(kind_of(event), to_json(event));
      update(table, event, todo);
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
    launcher.resume(go_on.attempt, table.at(go_on.attempt.task).last().pieces.back().cores.list());
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
    loop.post([this, id = report.id, watch = std::weak_ptr<bool>(alive)] {
      if (watch.expired()) return;
      const TaskEnd end = end_of(table.at(id), folder_of(table.at(id).spec));
      for (std::size_t k = 0; k < end_callbacks.size() && !watch.expired(); ++k) end_callbacks[k](end);
    });
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

  void carry_out(const StartTask& start) {
    happens({now(), Placed{{start.id, table.at(start.id).attempt_id().number + 1}, start.cores}});
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

  // --- the beginning ---

  Status replay(const Line& line) {
    const bool of_task = line.kind.starts_with("task.");
    if (!of_task && !line.kind.starts_with("pilot.")) return {};
    const auto broken = [&](const std::string& what) {
      return Error{fmt::format("journal.jsonl: record {} ({}): {}", line.sequence, line.kind, what)};
    };
    const auto payload = parse_json(line.payload);
    if (!payload) return broken("its payload is not JSON");
    if (line.kind == "pilot.open" && run_id.empty()) run_id = payload->text_or("run_id", "");
    time_base = std::max(time_base, payload->number_or("time_s", 0.0));
    if (!of_task) return {};
    const auto event = event_from_json(std::string(line.kind), *payload);
    if (!event) return broken(event.error().message);
    if (!belongs_here(*event, TaskId{static_cast<int>(payload->integer_or("id", -1))}))
      return broken("tells of a task that no earlier record submitted; somebody put this file together from others");
    (void)update(table, *event);
    return {};
  }

  Status replay() {
    GRANARY_CHECK(journal.for_each([this](const Line& line) { return replay(line); }));
    for (const Task& task : table.tasks) {
      ++folders[folder_of(task.spec)];
      if (has_ended(task.state) && !task.resumable) continue;
      if (const Status fits = check_fits(task.spec, scheduler.layouts()); !fits) {
        return Error{fmt::format("task \"{}\" {}", task.spec.name, fits.error().message)};
      }
    }
    return {};
  }

  bool belongs_here(const Event& event, TaskId id) const {
    const auto* submitted = std::get_if<Submitted>(&event.what);
    const auto* restored = std::get_if<Restored>(&event.what);
    if (submitted == nullptr && restored == nullptr) return table.has(id);
    const auto is_known = [this](const std::string& name) { return table.find(name) != nullptr; };
    const auto& after = submitted != nullptr ? submitted->spec.after : restored->task.spec.after;
    return id.value == static_cast<int>(table.tasks.size()) && std::all_of(after.begin(), after.end(), is_known);
  }

  Status begin() {
    const bool is_new = journal.n_records() == 0;
    if (run_id.empty()) run_id = new_run_id();
    json::Value nodes = json::Value::array();
    for (const Node& node : options.machine.nodes) {
      nodes.push(json::Value::object({{"name", node.name}, {"cores", node.cpus.size()}}));
    }
    opening = json::Value::object({{"time_s", now()},
                                   {"run_id", run_id},
                                   {"pid", static_cast<int>(getpid())},
                                   {"version", version()},
                                   {"nodes", std::move(nodes)}});
    record("pilot.open", opening);
    if (!is_new) take_up();
    GRANARY_CHECK(flush());
    GRANARY_CHECK(journal.healthy());
    if (journal.n_records() <= options.compact_above || journal.n_records() <= 2 * table.tasks.size()) return {};
    return compact();
  }

  /// Rewrites the journal with one record a task; what others have written stays as it is. Nothing runs now.
  Status compact() {
    Status read;
    const Status written = journal.rewrite([&](Journal& fresh) {
      bool first = true;
      const auto keep = [&](const Line& line) {
        const bool ours =
            line.kind.starts_with("task.") || line.kind.starts_with("pilot.") || line.kind.starts_with("node.");
        if (!ours || std::exchange(first, false)) {
          fresh.stamp_with(line.wall_time);
          fresh.add(line.kind, line.payload);
        }
        return Status();
      };
      read = journal.for_each(keep);
      fresh.stamp_with(std::nullopt);
      const auto add = [&](const std::string& kind, const json::Value& payload) {
        text.clear();
        append_json(text, payload);
        fresh.add(kind, text);
      };
      for (const Task& task : table.tasks) {
        const Event event{now(), Restored{task}};
        add(kind_of(event), to_json(event));
      }
      add("pilot.open", opening);
    });
    GRANARY_CHECK(read);
    return written;
  }

  /// Ends the orphans of the last pilot and queues their tasks again, and those that it had stopped itself.
  void take_up() {
    for (const TaskId id : active_tasks()) {
      const Task& task = table.at(id);
      const bool was_alive =
          launcher.end_orphan({task.last().pid, task.last().start_ticks}, mark_of(task.attempt_id()));
      happens({now(), Lost{task.attempt_id(), was_alive ? "the pilot died; the task still ran and was ended"
                                                        : "the pilot died, and the task with it"}});
    }
    for (std::size_t k = 0; k < table.tasks.size(); ++k) {
      if (table.tasks[k].resumable) happens({now(), Reopened{table.tasks[k].id}});
    }
    todo.clear();  // what ended in an earlier life was told there
    idle_told = false;
    turn_soon();
  }
};

Pilot::Pilot(std::unique_ptr<State> state) : state_(std::move(state)) {}

Pilot::~Pilot() {
  if (state_) (void)state_->journal.append("pilot.close", json::Value::object({{"time_s", now()}}));
}

Result<std::unique_ptr<Pilot>> Pilot::open(PilotOptions options, EventLoop& loop, Launcher& launcher,
                                           Journal& journal) {
  std::error_code error;
  options.dir = fs::absolute(options.dir, error).lexically_normal();
  std::unique_ptr<Pilot> pilot(new Pilot(std::make_unique<State>(std::move(options), loop, launcher, journal)));
  GRANARY_CHECK(pilot->state_->replay());
  GRANARY_CHECK(pilot->state_->begin());
  return pilot;
}

Result<TaskId> Pilot::submit(TaskSpec spec) {
  State& state = *state_;
  if (const Task* known = state.table.find(spec.name)) {
    if (known->spec != spec) {
      return Error{fmt::format(
          "task \"{}\" is in the journal with other settings; use another name, or another folder (--dir)", spec.name)};
    }
    if (has_ended(known->state)) state.act(Report{known->id});
    return known->id;
  }
  if (spec.name.empty() || spec.command.empty() || spec.command[0].empty()) {
    return Error{fmt::format("task \"{}\" has no {}", spec.name, spec.name.empty() ? "name" : "command")};
  }
  for (const std::string& before : spec.after) {
    if (state.table.find(before) != nullptr) continue;
    return Error{fmt::format("task \"{}\" comes after \"{}\", which has not been submitted", spec.name, before)};
  }
  if (const Status fits = check_fits(spec, state.scheduler.layouts()); !fits) {
    return Error{fmt::format("task \"{}\" {}", spec.name, fits.error().message)};
  }
  const TaskId id{static_cast<int>(state.table.tasks.size())};
  ++state.folders[state.folder_of(spec)];
  state.idle_told = false;
  state.happens({now(), Submitted{id, std::move(spec)}});
  return id;
}

void Pilot::lose_node(int node, const std::string& reason) { state_->lose_node(node, reason); }
void Pilot::regain_node(int node) { state_->regain_node(node); }

void Pilot::deadline(double wall_time) {
  state_->deadline = now() + wall_time - state_->loop.wall_time();
  state_->turn_soon();
}

void Pilot::stop(TaskId id, const std::string& reason) {
  if (state_->table.has(id) && !has_ended(state(id))) state_->happens({now(), StopAsked{id, reason, false}});
}

void Pilot::stop_all(const std::string& reason) {
  if (state_->stopping) return;
  state_->stopping = true;
  state_->stop_reason = reason;
  state_->stop_active();
}

bool Pilot::stopping() const { return state_->stopping; }
void Pilot::on_end(std::function<void(const TaskEnd&)> callback) {
  state_->end_callbacks.push_back(std::move(callback));
}
void Pilot::on_idle(std::function<void()> callback) { state_->idle_callbacks.push_back(std::move(callback)); }
bool Pilot::idle() const { return state_->idle(); }
const std::optional<Error>& Pilot::failure() const { return state_->failure; }

std::optional<TaskId> Pilot::find(const std::string& name) const {
  const Task* task = state_->table.find(name);
  return task == nullptr ? std::nullopt : std::optional(task->id);
}

TaskState Pilot::state(TaskId id) const { return state_->table.at(id).state; }
const TaskSpec& Pilot::spec(TaskId id) const { return state_->table.at(id).spec; }

std::optional<TaskEnd> Pilot::end(TaskId id) const {
  const Task& task = state_->table.at(id);
  if (!has_ended(task.state)) return std::nullopt;
  return end_of(task, state_->folder_of(task.spec));
}

std::vector<TaskEnd> Pilot::ends() const {
  std::vector<TaskEnd> ends;
  for (const Task& task : state_->table.tasks) {
    if (has_ended(task.state)) ends.push_back(end_of(task, state_->folder_of(task.spec)));
  }
  return ends;
}

double Pilot::now() const { return state_->now(); }
const Machine& Pilot::machine() const { return state_->options.machine; }
Usage Pilot::usage() const { return usage_of(state_->table, machine().n_cores(), now()); }
std::vector<Interval> Pilot::timeline() const { return timeline_of(state_->table, now()); }

json::Value Pilot::status() const {
  json::Value status = status_of(state_->table, state_->scheduler.resources(), now());
  status.set("stopping", state_->stopping);
  if (state_->failure) status.set("failure", state_->failure->message);
  return status;
}

Result<std::string> Pilot::explain(const std::string& name) const {
  if (const Task* task = state_->table.find(name)) {
    return granary::pilot::explain(*task, state_->table, state_->scheduler, now(), state_->stopping);
  }
  std::vector<std::string> names;
  for (const Task& task : state_->table.tasks) names.push_back(task.spec.name);
  const std::string near = json::did_you_mean(name, names);
  return Error{
      fmt::format("no task is called \"{}\".{}", name, near.empty() ? "" : fmt::format(" Did you mean \"{}\"?", near))};
}

json::Value Pilot::answer_submit(const json::Value& task) {
  json::Problems problems;
  json::Reader reader(task, "request", problems);
  TaskSpec spec = read_task(reader);
  if (!problems.empty()) return json::Value::object({{"error", problems.error().message}});
  if (stopping()) return json::Value::object({{"error", "the pilot is stopping; it takes no tasks any more"}});
  const std::string name = spec.name;
  const auto id = submit(std::move(spec));
  // Whoever asked is told once it cannot be lost any more.
  if (const Status written = state_->flush(); !written)
    return json::Value::object({{"error", written.error().message}});
  if (!id) return json::Value::object({{"error", id.error().message}});
  return json::Value::object({{"submitted", name}, {"id", id->value}});
}

json::Value Pilot::answer(const json::Value& request) {
  const auto refuse = [](const std::string& why) { return json::Value::object({{"error", why}}); };
  const std::string ask = request.text_or("ask", ""), name = request.text_or("task", "");
  if (ask == "submit") return answer_submit(request["task"]);
  if (ask == "status") return status();
  if (ask == "explain") {
    const auto text = explain(name);
    return text ? json::Value::object({{"text", *text}}) : refuse(text.error().message);
  }
  if (ask != "stop") return refuse(fmt::format("cannot \"{}\"; known are status, stop, explain, submit", ask));
  const std::string reason = request.text_or("reason", "asked to stop");
  if (name.empty()) {
    stop_all(reason);
  } else if (const auto id = find(name)) {
    stop(*id, reason);
  } else {
    return refuse(explain(name).error().message);
  }
  return json::Value::object({{"stopping", name.empty() ? "all" : name}});
}

}  // namespace granary::pilot
