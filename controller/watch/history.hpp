// What a journal tells a viewer: bursts, what happened in words, who ran on which cores. Pure: it is given the
// journal's lines one after the other. Lines of kinds it does not know are passed over, so a newer journal is readable
// too.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/json/value.hpp"
#include "controller/watch/core_history.hpp"
#include "controller/watch/view.hpp"
#include "pilot/journal/line.hpp"

namespace granary::watch {

class History {
 public:
  void take(const pilot::Line& line);

  std::uint64_t n_records() const { return n_records_; }
  double last_time() const { return last_time_; }  ///< pilot time of the last record [s]
  bool pilot_open() const { return pilot_open_; }  ///< the last pilot has not said that it ended (it may be dead)
  /// How a coupled campaign ended, and has not been taken up again since: steady, limit, stopped, failed.
  const std::optional<std::string>& ended() const { return ended_; }
  const std::string& ended_message() const { return ended_message_; }
  bool stop_asked() const { return stop_asked_; }
  /// A list of tasks that was asked to stop, to be taken up again.
  bool stopped_resumably() const { return stopped_resumably_; }

  int nodes() const { return nodes_; }
  int cores() const { return cores_; }
  const std::vector<Burst>& bursts() const { return bursts_; }   ///< the last one may still run: unknown end
  int rounds() const { return rounds_; }                         ///< whole ones
  const json::Value& steadiness() const { return steadiness_; }  ///< numbers of the last decision that had them
  const std::deque<Happening>& happenings() const { return happenings_; }
  std::uint64_t n_happenings() const { return n_happenings_; }
  std::int64_t fillers() const { return fillers_; }
  std::int64_t fillers_done() const { return fillers_done_; }
  CoreHistory core_history(double now) const;

 private:
  /// A task that has not ended.
  struct Task {
    std::string name, kind;
    double since = kUnknown;  ///< on its cores since; unknown: on none
    int cores = 0;
    bool stop_asked = false;
  };

  void pilot_opened(const json::Value& payload, double wall_time);
  void of_task(std::string_view kind, const json::Value& payload);
  void task_exited(Task& task, const json::Value& payload);
  void past_task(const json::Value& payload);
  void leave_cores(Task& task);
  void coupling_event(const json::Value& event);
  void decision(const json::Value& decision);
  void burst_started(const json::Value& decision);
  Burst* find(const std::string& folder);
  void say(Level level, std::string words);

  std::uint64_t n_records_ = 0;
  double last_time_ = 0.0;
  double base_time_ = 0.0, base_wall_ = kUnknown;  ///< pilot time and wall time of the last pilot.open [s]
  bool pilot_open_ = false;
  int nodes_ = 0, cores_ = 0;
  std::optional<std::string> ended_;
  std::string ended_message_;
  bool stop_asked_ = false, stopped_resumably_ = false;
  std::vector<Burst> bursts_;
  int rounds_ = 0;
  json::Value steadiness_;
  std::deque<Happening> happenings_;
  std::uint64_t n_happenings_ = 0;
  std::int64_t fillers_ = 0, fillers_done_ = 0;
  std::map<std::int64_t, Task> tasks_;
  CoreSeconds core_seconds_;
};

}  // namespace granary::watch
