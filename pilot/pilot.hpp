// Runs tasks on the cores it was given: event -> journal -> update -> schedule -> act. Knows nothing of DEM or PBM.
// The decisions are in task/update and schedule/scheduler, the processes in launch/; docs/pilot.md tells the whole.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pilot/journal/journal.hpp"
#include "pilot/launch/launcher.hpp"
#include "pilot/loop/event_loop.hpp"
#include "pilot/schedule/machine.hpp"
#include "pilot/task/spec.hpp"
#include "pilot/task/state.hpp"

namespace granary::pilot {

struct PilotOptions {
  std::filesystem::path dir;  ///< the campaign's folder; tasks' folders are relative to it
  Machine machine;
  /// A journal of more records than this, and more than twice as many as its tasks need, is compacted at the opening.
  std::uint64_t compact_above = 10'000;
  double sync_every = 0.25;  ///< a power cut loses at most this much of the journal [s]; 0: never waits for the disk
};

/// Core seconds since the pilot started (and in earlier lives of the same campaign).
struct Usage {
  double busy = 0.0;     ///< cores x time with a task running on them, fillers included
  double fillers = 0.0;  ///< of which fillers
  double total = 0.0;    ///< cores of the machine x time
};

/// A stretch of time in which an attempt ran without being suspended. Times: pilot time [s].
struct Interval {
  TaskId task;
  std::string name;
  int attempt = 0;
  bool fill = false;
  std::vector<int> cores;
  double start = 0.0;
  double end = 0.0;                        ///< now, if it still runs
  bool ended = true;                       ///< false: it still runs
  TaskState outcome = TaskState::running;  ///< of the attempt, in its last interval; suspended in those before
};

/// Pilot time: seconds since the campaign's first start, not counting the time when no pilot was alive.
class Pilot {
 public:
  /// Takes up the campaign the journal tells of (an empty journal: a new one). Attempts that were running are orphans:
  /// ended, recorded as lost, and their tasks queued again; so are tasks that stop_all() had stopped. What finished is
  /// never run again. `loop`, `launcher` and `journal` must outlive the pilot.
  static Result<std::unique_ptr<Pilot>> open(PilotOptions options, EventLoop& loop, Launcher& launcher,
                                             Journal& journal);
  ~Pilot();

  /// Queues a task; it starts from the loop, never within this call. A task of the same name that the journal knows is
  /// not queued again: its id comes back, and if it has ended, on_end is called for it again, from the loop. Errors:
  /// more cores than the machine has, unknown name in after[], same name but another spec, a full disk.
  Result<TaskId> submit(TaskSpec spec);

  /// Ends a task gracefully and for good (state stopped). A task that has ended is left alone.
  void stop(TaskId id, const std::string& reason);
  /// Starts nothing any more and ends all that runs, gracefully; then idle. A pilot opened later on the same journal
  /// goes on.
  void stop_all(const std::string& reason);
  bool stopping() const;

  /// A node of the machine (by index) has died: its cores are out until regain_node(). What ran there alone is lost at
  /// once; of what ran there and elsewhere, the rest is killed first. Their tasks queue again, which is no failed try.
  void lose_node(int node, const std::string& reason);
  void regain_node(int node);
  /// The allocation ends at this wall time [s since 1970-01-01 UTC]: a task whose expected running time (its timeout)
  /// goes beyond is not started, unless it can be stopped and resumed. When only such tasks are left, stop_all().
  void deadline(double wall_time);

  /// Called from the loop, once a task has ended for good. Submitting or stopping tasks in it is fine.
  void on_end(std::function<void(const TaskEnd&)> callback);
  /// Called from the loop each time the pilot has become idle.
  void on_idle(std::function<void()> callback);
  /// Nothing waits or runs (after stop_all(): nothing runs).
  bool idle() const;
  /// Why the pilot stopped by itself: the journal cannot be written (a full disk). stop_all() has been done then.
  const std::optional<Error>& failure() const;

  std::optional<TaskId> find(const std::string& name) const;
  TaskState state(TaskId id) const;
  const TaskSpec& spec(TaskId id) const;
  std::optional<TaskEnd> end(TaskId id) const;  ///< nothing while it has not ended
  std::vector<TaskEnd> ends() const;            ///< all that have ended, by id

  double now() const;  ///< pilot time [s]
  const Machine& machine() const;
  Usage usage() const;
  std::vector<Interval> timeline() const;
  /// {time_s, stopping, cores, busy_cores, counts: {waiting: 3, ...}, tasks: [{name, state, attempt, cores, seconds}]
  /// (running ones)}
  json::Value status() const;
  /// Why a task waits, or what it did and what it cost, in words. Error: no such task (with a suggestion).
  Result<std::string> explain(const std::string& name) const;
  /// Answers a request of the control socket: {"ask": "status" | "stop" | "explain", "task": NAME, "reason": TEXT}, and
  /// {"ask": "submit", "task": {...}} with a task as a workflow writes it.
  json::Value answer(const json::Value& request);

 private:
  json::Value answer_submit(const json::Value& task);

  struct State;
  explicit Pilot(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace granary::pilot
