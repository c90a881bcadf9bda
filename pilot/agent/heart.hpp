// Heartbeats: who lives, known in time whatever the pilot's and the agents' main loops are busy with.
//
// An agent's guardian says every kBeat seconds "at my time t"; the pilot's heart, a thread of its own, notes it and
// says t back. So the guardian knows until when it was heard, and ends its tasks kLease seconds after the last such
// time: before the pilot, which waits kSilence seconds, calls the node lost and starts them elsewhere. No clock is
// compared with another's.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/result.hpp"
#include "pilot/protocol/secret.hpp"

namespace granary::pilot {

inline constexpr double kBeat = 0.5;     ///< [s]
inline constexpr double kLease = 3.0;    ///< the guardian ends its tasks so long after it was last heard [s]
inline constexpr double kSilence = 4.2;  ///< the pilot calls a node lost that it has not heard for so long [s]

/// The pilot's side: answers beats in a thread of its own, as long as it lives.
class Heart {
 public:
  static Result<std::unique_ptr<Heart>> beat(const std::string& address, const Digest& secret);
  ~Heart();
  std::uint16_t port() const;
  /// Seconds since a beat of this agent (its name on the connection) came; infinity: never.
  double silence(const std::string& name) const;

 private:
  struct State;
  explicit Heart(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace granary::pilot
