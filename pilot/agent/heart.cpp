#include "pilot/agent/heart.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <limits>
#include <mutex>
#include <thread>
#include <unordered_map>

#include "pilot/protocol/listener.hpp"

namespace granary::pilot {

using Clock = std::chrono::steady_clock;

struct Heart::State {
  RealLoop loop;  ///< the thread's; made before it, ended after it
  std::unique_ptr<Listener> listener;
  int wake = eventfd(0, EFD_CLOEXEC);  ///< asks the thread to end
  std::thread thread;
  mutable std::mutex mutex;
  std::unordered_map<std::string, Clock::time_point> heard;

  Listener::Guest welcome(Channel& channel) {
    if (channel.role() != Role::heart) return {};
    return {[this, &channel](const json::Value& beat) {
              const std::lock_guard<std::mutex> lock(mutex);
              heard[channel.name()] = Clock::now();
              channel.send(beat);
            },
            {}};
  }
};

Heart::Heart(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<Heart>> Heart::beat(const std::string& address, const Digest& secret) {
  auto state = std::make_unique<State>();
  GRANARY_TRY(state->listener, Listener::listen(state->loop, address, secret,
                                                [s = state.get()](Channel& channel) { return s->welcome(channel); }));
  state->loop.watch(state->wake, [s = state.get()] { s->loop.stop(); });
  state->thread = std::thread([s = state.get()] {
    // Signals are for the main thread.
    sigset_t all;
    sigfillset(&all);
    (void)pthread_sigmask(SIG_BLOCK, &all, nullptr);
    s->loop.run();
  });
  return std::unique_ptr<Heart>(new Heart(std::move(state)));
}

Heart::~Heart() {
  const std::uint64_t one = 1;
  (void)!write(state_->wake, &one, sizeof one);
  state_->thread.join();
  state_->listener.reset();
  state_->loop.unwatch(state_->wake);
  close(state_->wake);
}

std::uint16_t Heart::port() const { return state_->listener->port(); }

double Heart::silence(const std::string& name) const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const auto found = state_->heard.find(name);
  if (found == state_->heard.end()) return std::numeric_limits<double>::infinity();
  return std::chrono::duration<double>(Clock::now() - found->second).count();
}

}  // namespace granary::pilot
