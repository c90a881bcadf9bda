#include "pilot/loop/virtual_loop.hpp"

#include <algorithm>

namespace granary::pilot {

TimerId VirtualLoop::at(double time, std::function<void()> fn) {
  const std::uint64_t id = ++last_id_;
  const double when = std::max(time, now_);
  events_.emplace(Key{when, id}, std::move(fn));
  time_of_.emplace(id, when);
  return TimerId{id};
}

void VirtualLoop::cancel(TimerId timer) {
  const auto found = time_of_.find(static_cast<std::uint64_t>(timer));
  if (found == time_of_.end()) return;
  events_.erase(Key{found->second, found->first});
  time_of_.erase(found);
}

void VirtualLoop::fire_first() {
  auto event = events_.extract(events_.begin());
  time_of_.erase(event.key().second);
  now_ = event.key().first;
  event.mapped()();
}

void VirtualLoop::run() {
  stopped_ = false;
  while (!stopped_ && !events_.empty()) fire_first();
}

void VirtualLoop::run_until(double time) {
  stopped_ = false;
  while (!stopped_ && !events_.empty() && events_.begin()->first.first <= time) fire_first();
  if (!stopped_) now_ = std::max(now_, time);
}

}  // namespace granary::pilot
