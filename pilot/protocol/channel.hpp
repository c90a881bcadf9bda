// One authenticated connection: JSON messages both ways, sealed and counted, many in a frame when many are sent at
// once.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/json/value.hpp"
#include "pilot/loop/real_loop.hpp"
#include "pilot/protocol/handshake.hpp"

namespace granary::pilot {

class Channel {
 public:
  /// All are called from the loop. A channel may be destroyed in any of them.
  struct Events {
    std::function<void()> open;                       ///< both sides have proved themselves
    std::function<void(const json::Value&)> message;  ///< always an object
    std::function<void(const std::string&)> closed;   ///< why; nothing comes any more
  };
  /// Takes the connected, non-blocking socket over. `loop` must outlive it. `keeps_running`: whether the loop runs on
  /// for its sake alone.
  Channel(RealLoop& loop, int fd, Handshake handshake, Events events, bool keeps_running = true);
  ~Channel();
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;

  /// Queues an object; what is queued in one turn of the loop leaves in as few frames as hold it. Before open, or after
  /// the end, it is dropped. False: it is longer than kLargestPayload bytes, and is not sent.
  bool send(const json::Value& message);
  /// Ends the connection; `closed` is not called.
  void close();
  Role role() const;
  const std::string& name() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace granary::pilot
