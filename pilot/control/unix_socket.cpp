#include "pilot/control/unix_socket.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace granary::pilot {
namespace {

constexpr const char* kSocketName = "control.sock";

/// Calls `use` with the socket's address. A socket's path holds 107 bytes; ours goes through the open folder's short
/// name.
template <class Use>
int with_address(const std::filesystem::path& dir, Use use) {
  const int folder = open(dir.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return -1;
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  fmt::format_to_n(address.sun_path, sizeof address.sun_path - 1, "/proc/self/fd/{}/{}", folder, kSocketName);
  const int result = use(reinterpret_cast<const sockaddr*>(&address), socklen_t{sizeof address});
  const int code = errno;
  close(folder);
  errno = code;
  return result;
}

}  // namespace

Result<int> listen_at(const std::filesystem::path& dir) {
  const std::filesystem::path file = dir / kSocketName;
  const auto failed = [&](const char* what) {
    return Error{fmt::format("{}: {}: {}", file.string(), what, std::strerror(errno))};
  };
  unlink(file.c_str());  // a dead pilot's: the caller holds the folder's lock
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return failed("no socket");
  // The mode is set by the umask at the very moment the file is made: it is never open to others.
  const mode_t before = umask(0177);
  const int bound =
      with_address(dir, [fd](const sockaddr* address, socklen_t size) { return bind(fd, address, size); });
  umask(before);
  if (bound != 0 || listen(fd, 16) != 0) {
    Error error = failed("cannot listen");
    close(fd);
    return error;
  }
  return fd;
}

int connect_to(const std::filesystem::path& dir) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  if (with_address(dir, [fd](const sockaddr* address, socklen_t size) { return connect(fd, address, size); }) == 0)
    return fd;
  const int code = errno;
  close(fd);
  errno = code;
  return -1;
}

int peer_uid(int socket) {
  ucred credentials = {};
  socklen_t size = sizeof credentials;
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return -1;
  return static_cast<int>(credentials.uid);
}

}  // namespace granary::pilot
