#include "pilot/loop/real_loop.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <map>
#include <unordered_map>

#include "common/assert.hpp"

namespace granary::pilot {

namespace asio = boost::asio;
using SteadyClock = std::chrono::steady_clock;

struct RealLoop::State {
  struct Watch {
    Watch(asio::io_context& io, int fd, std::function<void()> callback, bool keeps)
        : descriptor(io, fd), fn(std::move(callback)), keeps_running(keeps) {}
    asio::posix::stream_descriptor descriptor;
    std::function<void()> fn;
    bool keeps_running;
  };
  struct SignalHandler {
    explicit SignalHandler(asio::io_context& io) : signals(io) {}
    asio::signal_set signals;
    std::function<void(int)> fn;
  };
  using Key = std::pair<double, std::uint64_t>;  ///< time, then the order of asking

  asio::io_context io{1};  // one thread: Asio then takes no locks
  SteadyClock::time_point start = SteadyClock::now();
  asio::steady_timer alarm{io};  // armed for the first of `timers`
  double armed_for = -1.0;
  std::map<Key, std::function<void()>> timers;
  std::unordered_map<std::uint64_t, double> time_of;
  std::uint64_t last_id = 0;
  std::size_t n_posted = 0;
  std::unordered_map<int, std::shared_ptr<Watch>> watches;
  std::size_t n_keeping = 0;
  std::vector<std::shared_ptr<SignalHandler>> signal_handlers;
  bool stopped = false;

  double now() const { return std::chrono::duration<double>(SteadyClock::now() - start).count(); }

  bool anything_to_come() const { return !timers.empty() || n_posted > 0 || n_keeping > 0; }

  void arm() {
    if (timers.empty()) {
      if (armed_for >= 0.0) alarm.cancel();
      armed_for = -1.0;
      return;
    }
    const double first = timers.begin()->first.first;
    if (first == armed_for) return;
    armed_for = first;
    alarm.expires_at(start + std::chrono::ceil<SteadyClock::duration>(std::chrono::duration<double>(first)));
    alarm.async_wait([this](const boost::system::error_code& error) {
      if (error) return;  // armed anew, or cancelled
      armed_for = -1.0;
      fire_due();
    });
  }

  void fire_due() {
    const double until = now();
    while (!stopped && !timers.empty() && timers.begin()->first.first <= until) {
      auto event = timers.extract(timers.begin());
      time_of.erase(event.key().second);
      event.mapped()();
    }
    arm();
  }

  void wait_for(const std::shared_ptr<Watch>& watch) {
    watch->descriptor.async_wait(asio::posix::stream_descriptor::wait_read,
                                 [this, watch](const boost::system::error_code& error) {
                                   if (error || !watch->descriptor.is_open()) return;
                                   watch->fn();
                                   if (watch->descriptor.is_open()) wait_for(watch);
                                 });
  }

  void wait_for(const std::shared_ptr<SignalHandler>& handler) {
    handler->signals.async_wait([this, handler](const boost::system::error_code& error, int signal) {
      if (error) return;
      handler->fn(signal);
      wait_for(handler);
    });
  }
};

RealLoop::RealLoop() : state_(std::make_unique<State>()) {}

RealLoop::~RealLoop() {
  for (auto& [fd, watch] : state_->watches) watch->descriptor.release();
}

double RealLoop::now() const { return state_->now(); }

double RealLoop::wall_time() const {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

TimerId RealLoop::at(double time, std::function<void()> fn) {
  const std::uint64_t id = ++state_->last_id;
  state_->timers.emplace(State::Key{time, id}, std::move(fn));
  state_->time_of.emplace(id, time);
  state_->arm();
  return TimerId{id};
}

void RealLoop::post(std::function<void()> fn) {
  ++state_->n_posted;
  asio::post(state_->io, [state = state_.get(), fn = std::move(fn)] {
    --state->n_posted;
    fn();
  });
}

void RealLoop::cancel(TimerId timer) {
  const auto found = state_->time_of.find(static_cast<std::uint64_t>(timer));
  if (found == state_->time_of.end()) return;
  state_->timers.erase(State::Key{found->second, found->first});
  state_->time_of.erase(found);
  // The alarm may now ring for nothing once; that is cheaper than arming it anew for each timeout that did not happen.
  if (state_->timers.empty()) state_->arm();
}

void RealLoop::run() {
  state_->stopped = false;
  state_->io.restart();
  while (!state_->stopped && state_->anything_to_come()) state_->io.run_one();
}

void RealLoop::stop() {
  state_->stopped = true;
  asio::post(state_->io, [] {});  // wakes run_one()
}

void RealLoop::on_signals(const std::vector<int>& signals, std::function<void(int)> fn) {
  auto handler = std::make_shared<State::SignalHandler>(state_->io);
  for (const int signal : signals) handler->signals.add(signal);
  handler->fn = std::move(fn);
  state_->signal_handlers.push_back(handler);
  state_->wait_for(handler);
}

void RealLoop::watch(int fd, std::function<void()> fn, bool keeps_running) {
  GRANARY_ASSERT(state_->watches.count(fd) == 0, fd);
  auto watch = std::make_shared<State::Watch>(state_->io, fd, std::move(fn), keeps_running);
  state_->n_keeping += keeps_running;
  state_->watches.emplace(fd, watch);
  state_->wait_for(watch);
}

void RealLoop::unwatch(int fd) {
  const auto found = state_->watches.find(fd);
  if (found == state_->watches.end()) return;
  state_->n_keeping -= found->second->keeps_running;
  found->second->descriptor.release();
  state_->watches.erase(found);
}

void RealLoop::when_writable(int fd, std::function<void()> fn) {
  const auto found = state_->watches.find(fd);
  GRANARY_ASSERT(found != state_->watches.end(), fd);
  found->second->descriptor.async_wait(
      asio::posix::stream_descriptor::wait_write,
      [watch = found->second, fn = std::move(fn)](const boost::system::error_code& error) {
        if (!error && watch->descriptor.is_open()) fn();
      });
}

}  // namespace granary::pilot
