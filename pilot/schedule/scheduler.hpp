// Decides which ready tasks start on which cores, and which fillers give way or go on. Pure: no clock, no processes, no
// files. The rules, and why nothing starves: docs/pilot.md#scheduling.
//
// A decision costs O(log n) in tasks and nodes: ready tasks of equal needs are one group (ready_queue), nodes are
// sorted by the cores they can give (resources), and only what the table says has changed is looked at.
#pragma once

#include <limits>
#include <map>
#include <optional>
#include <set>
#include <variant>
#include <vector>

#include "pilot/schedule/layout.hpp"
#include "pilot/schedule/ready_queue.hpp"
#include "pilot/schedule/resources.hpp"
#include "pilot/task/table.hpp"

namespace granary::pilot {

struct StartTask {
  TaskId id;
  CoreSet cores;
};
struct SuspendFiller {
  TaskId id;
};
struct KillFiller {
  TaskId id;
};  ///< its cores are free only when it has ended
struct ResumeFiller {
  TaskId id;
  CoreSet cores;
};
using Decision = std::variant<StartTask, SuspendFiller, KillFiller, ResumeFiller>;

/// What the first waiting task is promised: some cores of some nodes, by a time (infinity: nobody knows).
struct Reservation {
  TaskId task;
  struct Part {
    int node = 0, cores = 0;
  };
  std::vector<Part> parts;
  double start = std::numeric_limits<double>::infinity();  ///< pilot time [s]
};

class Scheduler {
 public:
  /// `table` must outlive the scheduler.
  Scheduler(Table& table, Machine machine);

  /// What to do now, in this order. Done by the caller, each decision finds its cores free. Empty: nothing to do.
  ///  - Ready tasks go by priority, then by order of submission. The first one that cannot start gets a reservation;
  ///    later ones use what it does not need, or end before it.
  ///  - Cores of fillers count as free for ready tasks; the fillers on them give way at once.
  ///  - Fillers get what is idle after that, reserved cores too.
  ///  - What cannot end before `deadline` is not started unless it can be stopped and resumed.
  /// Times: pilot time [s].
  std::vector<Decision> decide(double now, double deadline = std::numeric_limits<double>::infinity());

  void lose_node(int node);
  void regain_node(int node);

  const Resources& resources() const { return resources_; }
  const Layouts& layouts() const { return layouts_; }
  const std::optional<Reservation>& reservation() const { return reservation_; }
  /// Whether ready tasks are left that could start but for the deadline, and no others.
  bool only_late_ones_left() const;
  /// Whether a ready task waits for nothing but a later deadline.
  bool is_late(TaskId id) const { return late_.count(id) != 0; }
  /// Whether a ready task has its cores already, but for fillers on them that are being killed.
  bool waits_for_fillers(TaskId id) const { return claims_.count(id) != 0; }
  /// Takes up what the table says has changed; decide() does it first.
  void catch_up();

 private:
  using Parts = std::vector<Reservation::Part>;

  void follow(const Task& task);
  bool ends_in_time(const TaskSpec& spec) const;
  bool set_late_aside(TaskId id);

  void start_light();
  void start_claimed();
  bool start_first();
  void backfill();
  void restore_for_memory();
  void backfill_short();
  void run_fillers();
  void resume_fillers(int lowest_priority);
  bool start_filler(const Task& task);

  std::optional<Parts> places(const Layout& layout, bool spread, const NodeIndex& nodes, bool reserved_too) const;
  std::optional<Parts> places(TaskId id, const NodeIndex& idle, const NodeIndex& all, bool reserved_too) const;
  CoreSet pick(const Parts& parts) const;
  void start_on(const Task& task, const Parts& parts);
  bool make_way(const CoreSet& cores);
  void book(const Task& task, const CoreSet& cores);

  void reserve_for(const Task& task);
  void promise(Reservation reservation, const Layout& layout);
  void improve_reservation();
  bool start_elsewhere(const Task& task);
  bool reservation_is_complete() const;
  void drop_reservation();

  Table& table_;
  Resources resources_;
  Layouts layouts_;
  ReadyQueue ready_, fillers_;
  std::set<TaskId> light_;
  std::set<TaskId> late_;             ///< ready, but they cannot end before the deadline
  std::map<TaskId, CoreSet> claims_;  ///< tasks that wait for fillers to be killed
  std::optional<Reservation> reservation_;
  double now_ = 0.0, deadline_ = std::numeric_limits<double>::infinity();
  std::set<TaskId> suspended_now_;
  std::vector<Decision> decisions_;
};

}  // namespace granary::pilot
