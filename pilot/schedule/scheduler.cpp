#include "pilot/schedule/scheduler.hpp"

#include <algorithm>
#include <utility>

#include "common/assert.hpp"

namespace granary::pilot {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

bool runs(const Task& task) { return task.state == TaskState::running; }

/// When a task that starts now is expected to have left its cores.
double expected_end(const Task& task, double now) {
  const double duration = task.spec.duration();
  if (duration <= 0.0) return kNever;
  // A filler that was suspended has run for a while already.
  return now + std::max(0.0, duration - (task.attempts.empty() ? 0.0 : task.last().ran(now)));
}

}  // namespace

Scheduler::Scheduler(Table& table, Machine machine)
    : table_(table), resources_(std::move(machine)), layouts_(resources_.machine()) {
  for (const Task& task : table_.tasks) follow(task);
  table_.changed.clear();
}

// --- following the table ---

void Scheduler::catch_up() {
  // Some tasks are named several times; the second time nothing is new.
  for (const TaskId id : table_.changed) follow(table_.at(id));
  table_.changed.clear();
}

/// Brings the queues and the book of cores to what the table says of one task.
void Scheduler::follow(const Task& task) {
  const Hold* hold = resources_.held_by(task.id);
  if (runs(task)) {
    if (hold == nullptr && !task.last().pieces.back().cores.empty()) book(task, task.last().pieces.back().cores);
    if (task.spec.fill) resources_.set_lends(task.id, task.ending == Ending::none);
  } else {
    resources_.release(task.id, task.state == TaskState::suspended);
  }
  const bool is_ready = task.state == TaskState::ready;
  if (!is_ready) late_.erase(task.id);
  if (const auto claim = claims_.find(task.id); claim != claims_.end() && !is_ready) {
    resources_.unclaim(claim->second);
    claims_.erase(claim);
  }
  if (task.spec.light) {
    if (is_ready && late_.count(task.id) == 0) {
      light_.insert(task.id);
    } else {
      light_.erase(task.id);
    }
    return;
  }
  ReadyQueue& queue = task.spec.fill ? fillers_ : ready_;
  const bool waits_elsewhere = claims_.count(task.id) != 0 || late_.count(task.id) != 0;
  if (is_ready && !waits_elsewhere) {
    if (!queue.has(task.id)) queue.insert(task, layouts_.of(task.spec));
  } else {
    queue.erase(task);
  }
}

void Scheduler::lose_node(int node) {
  resources_.lose_node(node);
  drop_reservation();
  for (auto claim = claims_.begin(); claim != claims_.end();) {
    bool there = false;
    claim->second.for_each([&](int core) { there = there || resources_.node_of(core) == node; });
    const TaskId id = claim->first;
    if (!there) {
      ++claim;
      continue;
    }
    resources_.unclaim(claim->second);
    claim = claims_.erase(claim);
    follow(table_.at(id));
  }
}

void Scheduler::regain_node(int node) { resources_.regain_node(node); }

bool Scheduler::ends_in_time(const TaskSpec& spec) const {
  return spec.resumable || now_ + spec.duration() <= deadline_;
}

/// True if the task was set aside because of the deadline.
bool Scheduler::set_late_aside(TaskId id) {
  const Task& task = table_.at(id);
  if (ends_in_time(task.spec)) return false;
  late_.insert(id);
  follow(task);
  return true;
}

bool Scheduler::only_late_ones_left() const {
  return !late_.empty() && ready_.empty() && fillers_.empty() && light_.empty() && claims_.empty();
}

// --- a round ---

std::vector<Decision> Scheduler::decide(double now, double deadline) {
  now_ = now;
  if (deadline != deadline_) {
    deadline_ = deadline;
    for (const TaskId id : std::exchange(late_, {})) follow(table_.at(id));
  }
  catch_up();
  start_light();
  start_claimed();
  restore_for_memory();
  while (start_first()) {
  }
  backfill();
  backfill_short();
  ready_.restore();
  run_fillers();
  suspended_now_.clear();
  return std::exchange(decisions_, {});
}

void Scheduler::start_light() {
  for (const TaskId id : std::set<TaskId>(light_)) {
    if (set_late_aside(id)) continue;
    light_.erase(id);
    decisions_.push_back(StartTask{id, {}});
  }
}

/// Tasks that were waiting for fillers to be killed.
void Scheduler::start_claimed() {
  for (auto claim = claims_.begin(); claim != claims_.end();) {
    const Task& task = table_.at(claim->first);
    bool ready = true;
    claim->second.for_each([&](int core) {
      if (resources_.is_free(core)) return;
      const Hold* hold = resources_.held_by(resources_.holder(core));
      ready = ready && hold->lends && table_.at(resources_.holder(core)).spec.preempt == Preempt::suspend;
    });
    const std::int64_t memory = layouts_.of(task.spec).memory;
    claim->second.for_each_stretch([&](const CoreSet::Stretch& stretch) {
      ready = ready && resources_.free_memory(resources_.node_of(stretch.first)) >= memory * stretch.count;
    });
    if (!ready) {
      ++claim;
      continue;
    }
    const CoreSet cores = std::move(claim->second);
    resources_.unclaim(cores);
    claim = claims_.erase(claim);
    (void)make_way(cores);
    book(task, cores);
    decisions_.push_back(StartTask{task.id, cores});
  }
}

/// Starts the first task in turn; if it cannot start, sees to its reservation. False: nothing more to do with it.
bool Scheduler::start_first() {
  const auto first = ready_.first();
  if (!first) {
    drop_reservation();
    return false;
  }
  if (set_late_aside(*first)) return true;
  const Task& task = table_.at(*first);
  if (reservation_ && reservation_->task != *first) drop_reservation();
  if (reservation_) {
    improve_reservation();
    if (reservation_is_complete()) {
      const Parts parts = reservation_->parts;
      drop_reservation();
      start_on(task, parts);
      return true;
    }
    if (start_elsewhere(task)) return true;
  } else if (const auto parts = places(*first, resources_.spare_idle(), resources_.spare(), false)) {
    start_on(task, *parts);
    return true;
  }
  ready_.pass_over(*first, false);
  if (!reservation_ && resources_.spare().at_least().size() > 1 && resources_.spare().at_least()[1] > 0)
    reserve_for(task);
  return false;
}

/// Later tasks use what the reservation does not need.
void Scheduler::backfill() {
  while (const auto next = ready_.first_fitting(resources_.spare())) {
    if (set_late_aside(*next)) continue;
    const Task& task = table_.at(*next);
    if (const auto parts = places(*next, resources_.spare_idle(), resources_.spare(), false)) {
      start_on(task, *parts);
    } else {
      const Layout& layout = ready_.layout(*next);
      ready_.pass_over(*next, layout.memory > 0 && layout.large == layout.small);
    }
  }
}

/// Groups that lack nothing but memory are looked at again when a node could help.
void Scheduler::restore_for_memory() {
  const std::vector<int>& gained = resources_.gained();
  if (gained.empty()) return;
  ready_.restore_memory([&](const Layout& layout) {
    return std::any_of(gained.begin(), gained.end(), [&](int node) {
      return resources_.spare().count(node) >= layout.small &&
             resources_.spare_memory(node) >= layout.small * layout.memory;
    });
  });
  resources_.forget_gained();
}

/// Tasks that end before the reservation begins may use the reserved cores until then.
void Scheduler::backfill_short() {
  if (!reservation_ || reservation_->start == kNever) return;
  while (const auto next = ready_.first_fitting(resources_.reserved_all(), reservation_->start - now_)) {
    if (set_late_aside(*next)) continue;
    if (const auto parts = places(*next, resources_.reserved_idle(), resources_.reserved_all(), true)) {
      start_on(table_.at(*next), *parts);
    } else {
      ready_.pass_over(*next, false);
    }
  }
}

// --- where a task goes ---

/// Nodes and cores for a task, none of which it has yet; nothing if there is not enough. Packing takes the node that
/// fits most tightly, spreading the emptiest.
std::optional<Scheduler::Parts> Scheduler::places(const Layout& layout, bool spread, const NodeIndex& nodes,
                                                  bool reserved_too) const {
  const std::vector<int>& at_least = nodes.at_least();
  const auto enough = [&](int cores, int n) {
    return cores <= nodes.largest() && at_least[static_cast<std::size_t>(cores)] >= n;
  };
  if (layout.nodes == 0 || !enough(layout.large, layout.n_large) || !enough(layout.small, layout.nodes))
    return std::nullopt;
  Parts parts;
  const int step = spread ? -1 : 1;
  // Where the search for the next node goes on: nodes before it are taken, or lack the memory.
  int count = 0, from = 0, cores = 0;
  while (static_cast<int>(parts.size()) < layout.nodes) {
    const int wanted = layout.cores_on(static_cast<int>(parts.size()));
    if (wanted != cores) {
      cores = wanted;
      count = spread ? nodes.largest() : wanted;
      from = 0;
    }
    int node = -1;
    while (count >= cores && count <= nodes.largest() && (node = nodes.next(count, from)) < 0) {
      count += step;
      from = 0;
    }
    if (node < 0) return std::nullopt;
    from = node + 1;
    const auto taken = [&](const Reservation::Part& part) { return part.node == node; };
    // Only the second kind of share, searched anew, can come upon nodes of the first one.
    if (cores == layout.small && layout.n_large < layout.nodes && std::any_of(parts.begin(), parts.end(), taken))
      continue;
    if (layout.memory > 0) {
      const std::int64_t memory = reserved_too ? resources_.free_memory(node) : resources_.spare_memory(node);
      if (memory < layout.memory * cores) continue;
    }
    parts.push_back({node, cores});
  }
  return parts;
}

std::optional<Scheduler::Parts> Scheduler::places(TaskId id, const NodeIndex& idle, const NodeIndex& all,
                                                  bool reserved_too) const {
  const Layout& layout = ready_.layout(id);
  const bool spread = table_.at(id).spec.placement == Placement::spread;
  auto parts = places(layout, spread, idle, reserved_too);
  return parts ? parts : places(layout, spread, all, reserved_too);
}

CoreSet Scheduler::pick(const Parts& parts) const {
  CoreSet cores;
  for (const Reservation::Part& part : parts) resources_.pick(part.node, part.cores, cores);
  return cores;
}

/// Starts the task there, or claims the cores for it while fillers on them end.
void Scheduler::start_on(const Task& task, const Parts& parts) {
  CoreSet cores = pick(parts);
  GRANARY_ASSERT(cores.size() == task.spec.cores(), task.spec.name);
  ready_.erase(task);
  if (make_way(cores)) {
    book(task, cores);
    decisions_.push_back(StartTask{task.id, std::move(cores)});
  } else {
    resources_.claim(cores);
    claims_.emplace(task.id, cores);
  }
}

/// Makes the fillers on these cores give way. False if one of them has to end first; the others then go on until it
/// has.
bool Scheduler::make_way(const CoreSet& cores) {
  if (resources_.n_lent() == 0) return true;
  std::set<TaskId> to_suspend, to_kill;
  cores.for_each([&](int core) {
    const TaskId holder = resources_.holder(core);
    if (holder == TaskId{}) return;
    (table_.at(holder).spec.preempt == Preempt::suspend ? to_suspend : to_kill).insert(holder);
  });
  for (const TaskId id : to_kill) {
    decisions_.push_back(KillFiller{id});
    resources_.set_lends(id, false);
  }
  if (!to_kill.empty()) return false;
  for (const TaskId id : to_suspend) {
    decisions_.push_back(SuspendFiller{id});
    resources_.release(id, true);
    suspended_now_.insert(id);
  }
  return true;
}

void Scheduler::book(const Task& task, const CoreSet& cores) {
  const std::int64_t memory = task.spec.cores() > 0 ? task.spec.memory_bytes / task.spec.cores() : 0;
  resources_.take(task.id, {cores, memory, expected_end(task, now_), task.spec.fill && task.ending == Ending::none});
}

}  // namespace granary::pilot
