#include "pilot/launch/run_program.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "pilot/launch/command.hpp"
#include "pilot/launch/spawn.hpp"

extern char** environ;

namespace granary::pilot {
namespace {

/// Closes what it holds when it goes.
struct Fds {
  std::vector<int> list;
  ~Fds() {
    for (const int fd : list) close(fd);
  }
  int add(int fd) { return list.push_back(fd), fd; }
  void close_now(int fd) {
    close(fd);
    std::erase(list, fd);
  }
};

/// The input as an open file: the program may read, seek or open it, and nobody waits for it to be taken.
int input_file(std::string_view input) {
  const int fd = memfd_create("input", MFD_CLOEXEC);
  for (std::size_t written = 0; fd >= 0 && written < input.size();) {
    const ssize_t n = write(fd, input.data() + written, input.size() - written);
    if (n < 0 && errno != EINTR) break;
    if (n > 0) written += static_cast<std::size_t>(n);
  }
  if (fd >= 0) lseek(fd, 0, SEEK_SET);
  return fd;
}

/// Reads what is there. False at its end.
bool take(int fd, std::string& text) {
  char buffer[65536];
  const ssize_t n = read(fd, buffer, sizeof buffer);
  if (n > 0) text.append(buffer, static_cast<std::size_t>(n));
  return n > 0 || (n < 0 && (errno == EINTR || errno == EAGAIN));
}

}  // namespace

Result<ProgramOutput> run_program(const std::vector<std::string>& argv, std::string_view input, double timeout_s) {
  if (argv.empty()) return Error{"no program to run", Exit::internal};
  const char* path = std::getenv("PATH");
  SpawnRequest request;
  GRANARY_TRY(request.file, find_executable(argv[0], "", path != nullptr ? path : ""));
  request.argv = argv;
  for (char** entry = environ; *entry != nullptr; ++entry) request.env.emplace_back(*entry);

  Fds fds;
  int out[2], err[2];
  if (pipe2(out, O_CLOEXEC) != 0) return Error{fmt::format("no pipe: {}", std::strerror(errno)), Exit::internal};
  fds.list.insert(fds.list.end(), {out[0], out[1]});
  if (pipe2(err, O_CLOEXEC) != 0) return Error{fmt::format("no pipe: {}", std::strerror(errno)), Exit::internal};
  fds.list.insert(fds.list.end(), {err[0], err[1]});
  request.stdin_fd = input_file(input);
  if (request.stdin_fd >= 0) fds.add(request.stdin_fd);
  request.stdout_fd = out[1];
  request.stderr_fd = err[1];
  GRANARY_TRY(const Spawned process, spawn(request));
  fds.add(process.pidfd);
  fds.close_now(out[1]);
  fds.close_now(err[1]);

  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(timeout_s);
  ProgramOutput output;
  std::array<pollfd, 3> waits{{{out[0], POLLIN, 0}, {err[0], POLLIN, 0}, {process.pidfd, POLLIN, 0}}};
  while (waits[0].fd >= 0 || waits[1].fd >= 0 || waits[2].fd >= 0) {
    const double left = std::chrono::duration<double>(deadline - Clock::now()).count();
    const int ready = poll(waits.data(), waits.size(), left > 0.0 ? static_cast<int>(left * 1e3) + 1 : 0);
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0 && left <= 0.0) {
      kill(-process.pid, SIGKILL);
      if (waits[2].fd >= 0) (void)reap(process.pidfd);
      return Error{fmt::format("{}: still ran after {:g} s and was ended", argv[0], timeout_s), Exit::task_failed};
    }
    if (waits[0].revents != 0 && !take(out[0], output.out)) waits[0].fd = -1;
    if (waits[1].revents != 0 && !take(err[0], output.err)) waits[1].fd = -1;
    if (waits[2].revents != 0) {
      kill(-process.pid, SIGKILL);  // what it left running would keep the pipes open
      const ProcessEnd end = reap(process.pidfd);
      output.exit_code = end.exit_code;
      output.signal = end.signal;
      waits[2].fd = -1;
    }
    for (pollfd& wait : waits) wait.revents = 0;
  }
  return output;
}

}  // namespace granary::pilot
