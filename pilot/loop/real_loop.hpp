// The real event loop, on Boost.Asio: timers, signals and readable files; nothing polls.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "pilot/loop/event_loop.hpp"

namespace granary::pilot {

class RealLoop final : public EventLoop {
 public:
  RealLoop();
  ~RealLoop() override;

  double now() const override;
  double wall_time() const override;
  TimerId at(double time, std::function<void()> fn) override;
  void post(std::function<void()> fn) override;
  void cancel(TimerId timer) override;
  void run() override;
  void stop() override;

  /// Calls `fn` each time one of these signals arrives (SIGINT, SIGTERM, ...) instead of the default action. A signal
  /// handler does not keep run() going.
  void on_signals(const std::vector<int>& signals, std::function<void(int)> fn);
  /// Calls `fn` each time `fd` (a socket, pidfd, pipe) is readable, until unwatch(fd). The caller keeps and closes fd,
  /// after unwatch(). `keeps_running`: whether run() goes on for its sake alone.
  void watch(int fd, std::function<void()> fn, bool keeps_running = true);
  void unwatch(int fd);
  /// Calls `fn` once, when a watched `fd` takes more output.
  void when_writable(int fd, std::function<void()> fn);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace granary::pilot
