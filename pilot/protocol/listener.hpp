// Where connections come in: each caller proves itself, and is then handed over as a Channel.
#pragma once

#include <functional>
#include <memory>

#include "pilot/protocol/channel.hpp"
#include "pilot/protocol/tcp.hpp"

namespace granary::pilot {

class Listener {
 public:
  /// Gives what is to be done with a caller's messages, once it has proved itself.
  struct Guest {
    std::function<void(const json::Value&)> message;
    std::function<void(const std::string&)> closed;
  };
  using Welcome = std::function<Guest(Channel&)>;

  /// `loop` must outlive it. The listener keeps the channels; they end with it, or when drop() is called.
  static Result<std::unique_ptr<Listener>> listen(RealLoop& loop, const std::string& address, const Digest& secret,
                                                  Welcome welcome, bool keeps_running = false);
  ~Listener();
  std::uint16_t port() const;
  /// Ends a connection without its `closed` being called. May be called from its own callbacks.
  void drop(const Channel& channel);

 private:
  struct State;
  explicit Listener(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace granary::pilot
