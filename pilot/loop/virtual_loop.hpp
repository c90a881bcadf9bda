// An event loop on virtual time: run() jumps from event to event. Deterministic; an hour of campaign takes
// microseconds.
#pragma once

#include <boost/heap/d_ary_heap.hpp>
#include <cstdint>
#include <deque>
#include <vector>

#include "pilot/loop/event_loop.hpp"

namespace granary::pilot {

class VirtualLoop final : public EventLoop {
 public:
  explicit VirtualLoop(double wall_start = 0.0) : wall_start_(wall_start) {}

  double now() const override { return now_; }
  double wall_time() const override { return wall_start_ + now_; }
  TimerId at(double time, std::function<void()> fn) override;
  void post(std::function<void()> fn) override { posted_.push_back({++n_asked_, std::move(fn)}); }
  void cancel(TimerId timer) override;
  /// Until no event is left, or stop().
  void run() override;
  /// Until no event is left before `time`; the clock then shows `time`.
  void run_until(double time);
  void stop() override { stopped_ = true; }

 private:
  /// What a TimerId leads to: its lower half is the slot, its upper half counts the slot's uses.
  struct Slot {
    std::uint32_t use = 1;
    std::function<void()> fn;  ///< empty: cancelled, or free
  };
  struct Due {
    double time;
    std::uint64_t asked;  ///< the order of asking
    std::uint32_t slot, use;
    bool operator<(const Due& other) const {  // a heap has its largest in front: the first to come
      return time != other.time ? time > other.time : asked > other.asked;
    }
  };
  struct Posted {
    std::uint64_t asked;
    std::function<void()> fn;
  };

  bool drop_cancelled();
  bool is_live(const Due& due) const { return slots_[due.slot].use == due.use; }
  void release(std::uint32_t slot);
  void fire_first();

  double now_ = 0.0;
  double wall_start_;
  bool stopped_ = false;
  std::uint64_t n_asked_ = 0;
  boost::heap::d_ary_heap<Due, boost::heap::arity<4>> heap_;
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> free_slots_;
  std::deque<Posted> posted_;
};

}  // namespace granary::pilot
