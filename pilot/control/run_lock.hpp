// One pilot at a time on a campaign's folder: DIR/pilot.lock is held as long as the pilot lives.
#pragma once

#include <filesystem>

#include "common/result.hpp"

namespace granary::pilot {

/// Whether somebody holds the lock of the folder, as far as its file system tells.
bool folder_is_locked(const std::filesystem::path& dir);

class RunLock {
 public:
  /// Error: another pilot (says its pid) is alive on this folder; the folder cannot be written.
  static Result<RunLock> take(const std::filesystem::path& dir);
  RunLock(RunLock&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  RunLock& operator=(RunLock&& other) noexcept;
  ~RunLock();

 private:
  explicit RunLock(int fd) : fd_(fd) {}
  int fd_ = -1;
};

}  // namespace granary::pilot
