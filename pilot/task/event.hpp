// All that can happen to a task. The journal keeps exactly these; replaying them gives the table back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pilot/task/core_set.hpp"
#include "pilot/task/spec.hpp"
#include "pilot/task/table.hpp"

namespace granary::pilot {

struct Submitted {
  TaskId id;
  TaskSpec spec;
};
/// The scheduler gave it these cores: it starts.
struct Placed {
  AttemptId attempt;
  CoreSet cores;
};
struct Started {
  AttemptId attempt;
  int pid = 0;
  std::uint64_t start_ticks = 0;
};
struct StartFailed {
  AttemptId attempt;
  std::string reason;
};
/// All its processes are gone.
struct Exited {
  AttemptId attempt;
  int exit_code = -1;
  int signal = 0;
  double cpu_s = 0.0;
  std::vector<std::filesystem::path> missing;  ///< of produces[]
};
/// `resumable`: the pilot ends, a later one takes the task up again.
struct StopAsked {
  TaskId id;
  std::string reason;
  bool resumable = false;
};
struct TimedOut {
  AttemptId attempt;
};
/// The grace time after its stop signal is over.
struct GraceOver {
  AttemptId attempt;
};
/// A filler gives way: suspended, resumed (maybe on other cores), or killed to start again later.
struct Suspended {
  AttemptId attempt;
};
struct Resumed {
  AttemptId attempt;
  CoreSet cores;
};
struct Preempted {
  AttemptId attempt;
};
/// The pilot or the node died under it.
struct Lost {
  AttemptId attempt;
  std::string reason;
};
/// A node of several died under it: what is left of the attempt is ended, then it is lost.
struct Abandoned {
  AttemptId attempt;
  std::string reason;
};
/// A task that stop_all() had stopped is taken up again.
struct Reopened {
  TaskId id;
};

/// A task with its whole past, from a compacted journal.
struct Restored {
  Task task;
};

struct Event {
  using What = std::variant<Submitted, Placed, Started, StartFailed, Exited, StopAsked, TimedOut, GraceOver, Suspended,
                            Resumed, Preempted, Lost, Abandoned, Reopened, Restored>;
  double time = 0.0;  ///< pilot time [s]
  What what;
};

/// The journal's kind of an event: "task.submit", "task.place", ...
std::string_view kind_of(const Event& event);
/// Appends its payload, as JSON.
void append(std::string& text, const Event& event);
/// Error: a kind or payload that is not ours.
Result<Event> event_from_json(std::string_view kind, const json::Value& payload);

}  // namespace granary::pilot
