#include "pilot/protocol/tcp.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace granary::pilot {
namespace {

using Found = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Found addresses_of(const std::string& name, std::uint16_t port) {
  addrinfo wanted = {};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (getaddrinfo(name.c_str(), std::to_string(port).c_str(), &wanted, &found) != 0) found = nullptr;
  return {found, &freeaddrinfo};
}

int new_socket(int family) { return socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); }

/// Messages are small and somebody waits for each: no gathering.
void send_at_once(int fd) {
  const int yes = 1;
  (void)setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

Result<Listening> listen_at(const sockaddr* address, socklen_t size) {
  const int fd = new_socket(address->sa_family);
  sockaddr_storage bound = {};
  socklen_t bound_size = sizeof bound;
  if (fd < 0 || bind(fd, address, size) != 0 || listen(fd, 256) != 0 ||
      getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &bound_size) != 0) {
    const int code = errno;
    if (fd >= 0) close(fd);
    return Error{std::strerror(code), Exit::internal};
  }
  const auto port = bound.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(&bound)->sin6_port
                                                : reinterpret_cast<sockaddr_in*>(&bound)->sin_port;
  return Listening{fd, ntohs(port)};
}

/// Nothing, or errno.
int connect_within(int fd, const addrinfo& address, double timeout_s) {
  if (connect(fd, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  pollfd wait{fd, POLLOUT, 0};
  if (poll(&wait, 1, static_cast<int>(timeout_s * 1e3) + 1) <= 0) return ETIMEDOUT;
  int code = 0;
  socklen_t size = sizeof code;
  return getsockopt(fd, SOL_SOCKET, SO_ERROR, &code, &size) == 0 ? code : errno;
}

}  // namespace

Result<Listening> listen_tcp(const std::string& address) {
  const Found found = addresses_of(address, 0);
  for (const addrinfo* one = found.get(); one != nullptr; one = one->ai_next) {
    auto listening = listen_at(one->ai_addr, one->ai_addrlen);
    if (listening) return listening;
  }
  sockaddr_in any = {};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_ANY);
  auto listening = listen_at(reinterpret_cast<const sockaddr*>(&any), sizeof any);
  if (!listening)
    return Error{fmt::format("no TCP port can be listened on: {}", listening.error().message), Exit::internal};
  return listening;
}

Result<int> connect_tcp(const std::vector<std::string>& addresses, std::uint16_t port, double timeout_s) {
  std::string tried;
  for (const std::string& name : addresses) {
    const Found found = addresses_of(name, port);
    if (!found) tried += fmt::format(" {} (no such host)", name);
    for (const addrinfo* one = found.get(); one != nullptr; one = one->ai_next) {
      const int fd = new_socket(one->ai_family);
      const int code = fd < 0 ? errno : connect_within(fd, *one, timeout_s);
      if (code == 0) return send_at_once(fd), fd;
      if (fd >= 0) close(fd);
      tried += fmt::format(" {} ({})", name, std::strerror(code));
    }
  }
  return Error{fmt::format("port {} cannot be reached at{}", port, tried)};
}

std::string host_name() {
  char name[256] = {};
  (void)gethostname(name, sizeof name - 1);
  return name;
}

}  // namespace granary::pilot
