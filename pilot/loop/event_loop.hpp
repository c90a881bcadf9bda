// Time and its events, behind an interface: the real loop (loop/real_loop, Boost.Asio) and the virtual one
// (loop/virtual_loop) drive the same scheduler, pilot and controller.
#pragma once

#include <cstdint>
#include <functional>

namespace granary::pilot {

enum class TimerId : std::uint64_t { none = 0 };

/// Single-threaded: every function is called from the loop's own thread, every callback runs on it.
class EventLoop {
 public:
  virtual ~EventLoop() = default;

  virtual double now() const = 0;        ///< [s] since the loop was made; never goes back
  virtual double wall_time() const = 0;  ///< [s] since 1970-01-01 UTC (virtual: a fixed start plus now())

  /// Calls `fn` once, at `time` on the clock of now() (at once, but not within this call, if that is over).
  /// Calls of the same time come in the order they were asked for.
  virtual TimerId at(double time, std::function<void()> fn) = 0;
  TimerId after(double seconds, std::function<void()> fn) { return at(now() + seconds, std::move(fn)); }
  /// As soon as the current callback has returned.
  virtual void post(std::function<void()> fn) = 0;
  /// A timer that has fired, or `none`, is no harm.
  virtual void cancel(TimerId timer) = 0;

  /// Until stop(), or until nothing can happen any more.
  virtual void run() = 0;
  virtual void stop() = 0;
};

}  // namespace granary::pilot
