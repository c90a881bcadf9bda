#include "pilot/control/run_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <utility>

#include "common/files.hpp"

namespace granary::pilot {
namespace {

// An "open file description" lock: it goes when the last copy of our descriptor does, whatever kills us, and others can
// ask for it without taking it.
struct flock whole_file() {
  struct flock lock = {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

std::filesystem::path lock_file(const std::filesystem::path& dir) { return dir / "pilot.lock"; }

/// A process that a pilot was just making when it was killed holds the lock until it has closed its files.
constexpr int kMostAttempts = 50;
constexpr std::chrono::milliseconds kBetweenAttempts{10};

bool is_gone(const std::string& pid) {
  const long number = std::strtol(pid.c_str(), nullptr, 10);
  return number > 0 && kill(static_cast<pid_t>(number), 0) != 0 && errno == ESRCH;
}

}  // namespace

Result<RunLock> RunLock::take(const std::filesystem::path& dir) {
  GRANARY_CHECK(make_folders(dir));
  const std::filesystem::path file = lock_file(dir);
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return Error{fmt::format("{}: cannot be opened: {}", file.string(), std::strerror(errno))};
  RunLock lock(fd);
  struct flock wanted = whole_file();
  for (int attempt = 0; fcntl(fd, F_OFD_SETLK, &wanted) != 0; ++attempt) {
    if (errno != EAGAIN && errno != EACCES)
      return Error{fmt::format("{}: cannot be locked: {}", file.string(), std::strerror(errno))};
    const std::string pid = read_text(file).value_or("?");
    if (attempt < kMostAttempts && is_gone(pid)) {
      std::this_thread::sleep_for(kBetweenAttempts);
      continue;
    }
    return Error{fmt::format(
        "{}: a pilot is running on this folder (process {}). See `granary status`, or end it with `granary stop`.",
        dir.string(), pid.substr(0, pid.find('\n')))};
  }
  const std::string pid = fmt::format("{}\n", getpid());
  // Only for people to read: a full disk must not keep us from resuming.
  if (ftruncate(fd, 0) != 0 || pwrite(fd, pid.data(), pid.size(), 0) < 0) return lock;
  return lock;
}

RunLock& RunLock::operator=(RunLock&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

RunLock::~RunLock() {
  if (fd_ >= 0) close(fd_);
}

bool folder_is_locked(const std::filesystem::path& dir) {
  const int fd = open(lock_file(dir).c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return false;
  struct flock wanted = whole_file();
  const bool asked = fcntl(fd, F_OFD_GETLK, &wanted) == 0;
  close(fd);
  return asked && wanted.l_type != F_UNLCK;
}

}  // namespace granary::pilot
