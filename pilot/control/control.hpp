// DIR/control.sock: one JSON line in, one out. Mode 0600, and only this user's (or root's) processes are answered.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "common/json/value.hpp"
#include "common/result.hpp"
#include "pilot/loop/real_loop.hpp"

namespace granary::pilot {

/// Largest message either side takes [bytes]; a longer one ends the connection with an error.
inline constexpr std::size_t kLargestMessage = 1 << 20;

/// Listens as long as it lives. `loop` must outlive it; the caller holds the folder's RunLock (so a socket file that is
/// there already is a dead pilot's and is replaced).
class ControlServer {
 public:
  using Answer = std::function<json::Value(const json::Value& request)>;
  static Result<ControlServer> listen(RealLoop& loop, const std::filesystem::path& dir, Answer answer);
  ControlServer(ControlServer&&) noexcept;
  ControlServer& operator=(ControlServer&&) noexcept;
  ~ControlServer();

 private:
  struct State;
  explicit ControlServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// Asks the pilot of a folder: {"ask": "status"}; over TCP if it is on another host. Errors: no pilot alive there (says
/// so, and what to do), no answer in time, an answer with "error" in it.
Result<json::Value> ask_pilot(const std::filesystem::path& dir, const json::Value& request, double timeout_s = 5.0);
/// Whether a pilot is alive on the folder, here or on another host.
bool pilot_is_alive(const std::filesystem::path& dir);

}  // namespace granary::pilot
