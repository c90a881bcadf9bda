// The life of a task as a pure function: what happens, and what follows from it. No clock, no processes, no files.
#pragma once

#include <variant>
#include <vector>

#include "common/result.hpp"
#include "pilot/task/event.hpp"
#include "pilot/task/table.hpp"

namespace granary::pilot {

struct Spawn {
  AttemptId attempt;
};
struct AskToEnd {
  AttemptId attempt;
  int signal = 0;
};
struct Kill {
  AttemptId attempt;
};
struct Pause {
  AttemptId attempt;
};
struct Continue {
  AttemptId attempt;
};  ///< on the cores of its newest piece
enum class Alarm { timeout, grace };
struct SetAlarm {
  AttemptId attempt;
  Alarm alarm = Alarm::timeout;
  double after = 0.0;
};
struct ClearAlarm {
  AttemptId attempt;
  Alarm alarm = Alarm::timeout;
};
/// It has ended for good: tell who wants to know.
struct Report {
  TaskId id;
};

using Action = std::variant<Spawn, AskToEnd, Kill, Pause, Continue, SetAlarm, ClearAlarm, Report>;

/// Applies an event to the table. An event that comes too late (about an attempt that is over, or a state it does not
/// apply to) changes nothing and gives no actions: so twice does no harm. Dependencies of a Submitted task must be in
/// the table.
std::vector<Action> update(Table& table, const Event& event);
/// Likewise; what follows is appended to `actions`.
void update(Table& table, Event event, std::vector<Action>& actions);

}  // namespace granary::pilot
