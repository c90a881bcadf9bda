// TCP sockets: the system calls, nothing else. All non-blocking, closed on execute.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::pilot {

struct Listening {
  int fd = -1;
  std::uint16_t port = 0;
};

/// Listens on `address` (a name or number) and a free port; on every address of this machine if that one is not its
/// own. The caller closes it.
Result<Listening> listen_tcp(const std::string& address);

/// A socket connected to the first of the addresses that takes the call. Blocks for `timeout_s` at most.
Result<int> connect_tcp(const std::vector<std::string>& addresses, std::uint16_t port, double timeout_s);

/// What gethostname() says.
std::string host_name();

}  // namespace granary::pilot
