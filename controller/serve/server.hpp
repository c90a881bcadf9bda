// A small web page on loopback (Boost.Beast): one thread, GET only, server-sent events; docs/watch.md.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/result.hpp"

namespace granary::serve {

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< of this machine
  int port = 0;                       ///< 0: any that is free
  double period = 1.0;                ///< between two looks while somebody watches [s]
};

inline constexpr int kMostConnections = 32;

class Server {
 public:
  /// `view`: the view as one line of JSON; called from run(), only while somebody wants it.
  /// Errors: an address that is none, or not ours; a port that is taken.
  static Result<Server> open(const ServerOptions& options, std::function<std::string()> view);
  Server(Server&&) noexcept;
  Server& operator=(Server&&) noexcept;
  ~Server();

  /// With the token: who has it may look.
  std::string url() const;
  int port() const;
  /// Answers until SIGINT or SIGTERM.
  void run();

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace granary::serve
