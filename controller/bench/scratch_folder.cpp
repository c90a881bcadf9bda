#include "controller/bench/scratch_folder.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <thread>
#include <utility>

namespace granary::bench {
namespace {

namespace fs = std::filesystem;

/// What a user or a batch system ends a program with, unless whoever started us has it ignored (nohup).
sigset_t signals_that_end() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now = {};
    if (sigaction(signal, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) sigaddset(&set, signal);
  }
  return set;
}

void take_away(const fs::path& folder) {
  std::error_code ignored;
  // A program that still runs may make a file between the listing and the removal.
  for (int attempt = 0; attempt < 10 && fs::exists(folder, ignored); ++attempt) fs::remove_all(folder, ignored);
}

}  // namespace

struct ScratchFolder::Watched {
  explicit Watched(fs::path folder) : path(std::move(folder)) {
    const sigset_t set = signals_that_end();
    (void)pthread_sigmask(SIG_BLOCK, &set, &before);  // of every thread to come: the signals wait for the watch
    signals = signalfd(-1, &set, SFD_CLOEXEC);
    done = eventfd(0, EFD_CLOEXEC);
    watch = std::thread([this] { wait_for_a_signal(); });
  }
  ~Watched() {
    (void)eventfd_write(done, 1);
    watch.join();
    close(signals);
    close(done);
    (void)pthread_sigmask(SIG_SETMASK, &before, nullptr);
    take_away(path);
  }
  Watched(const Watched&) = delete;
  Watched& operator=(const Watched&) = delete;

  void wait_for_a_signal() const {
    pollfd wanted[] = {{signals, POLLIN, 0}, {done, POLLIN, 0}};
    while (poll(wanted, 2, -1) < 0) continue;
    signalfd_siginfo got = {};
    if ((wanted[1].revents & POLLIN) != 0 || read(signals, &got, sizeof got) != sizeof got) return;
    const auto signal = static_cast<int>(got.ssi_signo);
    fmt::print(stderr, "interrupted ({}): {} is taken away, no figures are kept\n", strsignal(signal), path.string());
    take_away(path);
    _exit(128 + signal);
  }

  fs::path path;
  sigset_t before = {};
  int signals = -1, done = -1;
  std::thread watch;
};

std::optional<ScratchFolder> ScratchFolder::make(const fs::path& parent) {
  std::string path = (parent / "granary-bench-XXXXXX").string();
  if (mkdtemp(path.data()) == nullptr) return std::nullopt;
  return ScratchFolder(std::make_unique<Watched>(path));
}

ScratchFolder::ScratchFolder(std::unique_ptr<Watched> watched) : watched_(std::move(watched)) {}
ScratchFolder::ScratchFolder(ScratchFolder&&) noexcept = default;
ScratchFolder::~ScratchFolder() = default;
const fs::path& ScratchFolder::path() const { return watched_->path; }

}  // namespace granary::bench
