#include "controller/monitor/follow.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "common/json/io.hpp"

namespace granary::monitor {

namespace fs = std::filesystem;

namespace {

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

int end_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  sigprocmask(SIG_BLOCK, &set, nullptr);
  return ::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}

Error refused(const char* what) {
  return Error{fmt::format("granary-monitor: {} was refused: {}.", what, std::strerror(errno)), Exit::internal};
}

/// Notices about the folder (the file appears) until the file is there, then about the file alone: a DEM's folder sees
/// many other writes.
class Notices {
 public:
  Notices(fs::path folder, fs::path file)
      : folder_(std::move(folder)), file_(std::move(file)), fd_(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)) {
    if (fd_.get() >= 0) folder_watch_ = ::inotify_add_watch(fd_.get(), folder_.c_str(), IN_CREATE | IN_MOVED_TO);
    look_for_file();
  }

  int get() const { return fd_.get(); }

  void drain() {
    alignas(inotify_event) std::array<char, 4096> buffer;
    while (::read(fd_.get(), buffer.data(), buffer.size()) > 0) {
    }
    look_for_file();
  }

 private:
  void look_for_file() {
    if (fd_.get() < 0 || watches_file_) return;
    watches_file_ = ::inotify_add_watch(fd_.get(), file_.c_str(), IN_MODIFY | IN_CLOSE_WRITE) >= 0;
    if (watches_file_ && folder_watch_ >= 0) ::inotify_rm_watch(fd_.get(), folder_watch_);
  }

  fs::path folder_, file_;
  Descriptor fd_;
  int folder_watch_ = -1;
  bool watches_file_ = false;
};

/// Judges the lines that are new; `none` if they decide nothing.
Result<Verdict> read_on(json::LineReader& reader, Watch& watch) {
  GRANARY_TRY(const std::vector<json::Value> lines, reader.next());
  for (const json::Value& line : lines) {
    GRANARY_TRY(Verdict said, watch.take(line));
    if (said.outcome != Outcome::none) return said;
  }
  return Verdict{};
}

/// The last word: all that is in the file, then `ended`.
Result<Verdict> read_to_end(json::LineReader& reader, Watch& watch, const fs::path& file) {
  GRANARY_TRY(Verdict said, read_on(reader, watch));
  if (said.outcome != Outcome::none) return said;
  if (reader.torn_bytes() > 0)
    return Error{fmt::format(
        "{}: its last line, number {}, is cut short after {} bytes. The program that wrote it was killed, or the disk "
        "is full: see its log beside the file, then run the burst again.",
        file.string(), watch.lines() + 1, reader.torn_bytes())};
  return watch.ended();
}

}  // namespace

Result<Verdict> follow(const FollowSettings& settings) {
  std::error_code fault;
  if (!fs::is_directory(settings.folder, fault))
    return Error{fmt::format("{}: there is no such folder. Give the folder of a burst, for example bursts/0001-dem.",
                             settings.folder.string())};
  const fs::path file = settings.folder / watched_file(settings.program);
  Watch watch(settings.program, settings.options, file.string());
  json::LineReader reader(file);
  if (settings.finished) return read_to_end(reader, watch, file);

  const Descriptor signals(end_signals());
  if (signals.get() < 0) return refused("a descriptor for signals");
  Notices notices(settings.folder, file);
  const Descriptor process(settings.pid ? static_cast<int>(::syscall(SYS_pidfd_open, *settings.pid, 0)) : -1);
  if (settings.pid && process.get() < 0 && errno != ESRCH) return refused("watching the process");
  const bool gone = settings.pid && process.get() < 0;

  const int patience = static_cast<int>(settings.look_every * 1e3);
  std::array<pollfd, 3> wakers{{{signals.get(), POLLIN, 0}, {process.get(), POLLIN, 0}, {notices.get(), POLLIN, 0}}};
  while (!gone) {
    GRANARY_TRY(Verdict said, read_on(reader, watch));
    if (said.outcome != Outcome::none) return said;
    if (::poll(wakers.data(), wakers.size(), patience) < 0 && errno != EINTR) return refused("waiting");
    if (wakers[0].revents != 0 || wakers[1].revents != 0) break;
    notices.drain();
  }
  return read_to_end(reader, watch, file);
}

}  // namespace granary::monitor
