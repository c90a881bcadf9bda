// An event loop on virtual time: run() jumps from event to event. Deterministic; an hour of campaign takes
// microseconds.
#pragma once

#include <map>
#include <unordered_map>
#include <utility>

#include "pilot/loop/event_loop.hpp"

namespace granary::pilot {

class VirtualLoop final : public EventLoop {
 public:
  explicit VirtualLoop(double wall_start = 0.0) : wall_start_(wall_start) {}

  double now() const override { return now_; }
  double wall_time() const override { return wall_start_ + now_; }
  TimerId at(double time, std::function<void()> fn) override;
  void post(std::function<void()> fn) override { at(now_, std::move(fn)); }
  void cancel(TimerId timer) override;
  /// Until no event is left, or stop().
  void run() override;
  /// Until no event is left before `time`; the clock then shows `time`.
  void run_until(double time);
  void stop() override { stopped_ = true; }

 private:
  using Key = std::pair<double, std::uint64_t>;  ///< time, then the order of asking
  void fire_first();

  double now_ = 0.0;
  double wall_start_;
  bool stopped_ = false;
  std::uint64_t last_id_ = 0;
  std::map<Key, std::function<void()>> events_;
  std::unordered_map<std::uint64_t, double> time_of_;
};

}  // namespace granary::pilot
