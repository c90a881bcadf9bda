#include "pilot/protocol/listener.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <list>

#include "common/log.hpp"

namespace granary::pilot {
namespace {

constexpr std::size_t kMostStrangers = 256;  ///< connections that have not proved themselves yet

}  // namespace

struct Listener::State {
  struct Caller {
    std::unique_ptr<Channel> channel;
    Guest guest;
    bool known = false;
  };

  RealLoop& loop;
  Listening listening;
  Digest secret;
  Welcome welcome;
  bool keeps_running;
  std::list<Caller> callers;
  std::size_t n_strangers = 0;

  void accept_all() {
    for (int fd; (fd = accept4(listening.fd, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK)) >= 0;) {
      if (n_strangers < kMostStrangers) {
        take_in(fd);
      } else {
        log::warning("protocol", "refused a connection: too many have not proved themselves yet");
        close(fd);
      }
    }
  }

  void take_in(int fd) {
    ++n_strangers;
    const auto caller = callers.emplace(callers.end());
    caller->channel = std::make_unique<Channel>(loop, fd, Handshake::answer(secret),
                                                Channel::Events{[this, caller] {
                                                                  --n_strangers;
                                                                  caller->known = true;
                                                                  caller->guest = welcome(*caller->channel);
                                                                },
                                                                [caller](const json::Value& message) {
                                                                  if (caller->guest.message)
                                                                    caller->guest.message(message);
                                                                },
                                                                [this, caller](const std::string& why) {
                                                                  if (!caller->known) --n_strangers;
                                                                  forget(caller);
                                                                  if (caller->guest.closed) caller->guest.closed(why);
                                                                }},
                                                keeps_running);
  }

  /// Not at once: the caller's own callback may be what is running.
  void forget(std::list<Caller>::iterator caller) {
    const std::shared_ptr<std::list<Caller>> gone = std::make_shared<std::list<Caller>>();
    gone->splice(gone->end(), callers, caller);
    loop.post([gone] {});
  }
};

Listener::Listener(std::unique_ptr<State> state) : state_(std::move(state)) {}

Listener::~Listener() {
  state_->loop.unwatch(state_->listening.fd);
  close(state_->listening.fd);
}

std::uint16_t Listener::port() const { return state_->listening.port; }

void Listener::drop(const Channel& channel) {
  for (auto one = state_->callers.begin(); one != state_->callers.end(); ++one) {
    if (one->channel.get() != &channel) continue;
    one->channel->close();
    return state_->forget(one);
  }
}

Result<std::unique_ptr<Listener>> Listener::listen(RealLoop& loop, const std::string& address, const Digest& secret,
                                                   Welcome welcome, bool keeps_running) {
  GRANARY_TRY(const Listening listening, listen_tcp(address));
  std::unique_ptr<State> state(new State{loop, listening, secret, std::move(welcome), keeps_running, {}, 0});
  loop.watch(
      listening.fd, [s = state.get()] { s->accept_all(); }, false);
  return std::unique_ptr<Listener>(new Listener(std::move(state)));
}

}  // namespace granary::pilot
