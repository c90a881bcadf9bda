#include "pilot/loop/virtual_loop.hpp"

#include <algorithm>

namespace granary::pilot {

TimerId VirtualLoop::at(double time, std::function<void()> fn) {
  if (free_slots_.empty()) {
    free_slots_.push_back(static_cast<std::uint32_t>(slots_.size()));
    slots_.emplace_back();
  }
  const std::uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  slots_[slot].fn = std::move(fn);
  const std::uint32_t use = slots_[slot].use;
  heap_.push({std::max(time, now_), ++n_asked_, slot, use});
  return TimerId{std::uint64_t{use} << 32U | slot};
}

void VirtualLoop::release(std::uint32_t slot) {
  slots_[slot].fn = nullptr;
  if (++slots_[slot].use == 0) slots_[slot].use = 1;  // 0 would be TimerId::none
  free_slots_.push_back(slot);
}

void VirtualLoop::cancel(TimerId timer) {
  const auto id = static_cast<std::uint64_t>(timer);
  const auto slot = static_cast<std::uint32_t>(id), use = static_cast<std::uint32_t>(id >> 32U);
  // What is left of it in the heap is dropped when its time comes.
  if (slot < slots_.size() && slots_[slot].use == use && use != 0) release(slot);
}

/// Takes cancelled events off the front; whether anything is left to happen.
bool VirtualLoop::drop_cancelled() {
  while (!heap_.empty() && !is_live(heap_.top())) heap_.pop();
  return !heap_.empty() || !posted_.empty();
}

void VirtualLoop::fire_first() {
  const bool timer_first =
      !heap_.empty() && (posted_.empty() || (heap_.top().time <= now_ && heap_.top().asked < posted_.front().asked));
  std::function<void()> fn;
  if (timer_first) {
    const Due due = heap_.top();
    heap_.pop();
    now_ = due.time;
    fn = std::move(slots_[due.slot].fn);
    release(due.slot);
  } else {
    fn = std::move(posted_.front().fn);
    posted_.pop_front();
  }
  fn();
}

void VirtualLoop::run() {
  stopped_ = false;
  while (!stopped_ && drop_cancelled()) fire_first();
}

void VirtualLoop::run_until(double time) {
  stopped_ = false;
  while (!stopped_ && drop_cancelled() && (!posted_.empty() || heap_.top().time <= time)) fire_first();
  if (!stopped_) now_ = std::max(now_, time);
}

}  // namespace granary::pilot
