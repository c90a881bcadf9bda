#include "pilot/launch/spawn_limit.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <set>
#include <utility>

#include "pilot/launch/prepared_processes.hpp"

extern char** environ;

namespace granary::pilot {

Result<double> bare_spawn_seconds(const std::vector<std::string>& argv, int count, int in_flight) {
  std::vector<char*> arguments;
  for (const std::string& argument : argv) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  std::set<int> running;
  const auto wait_for_one = [&] {
    // Only children of ours are asked for: the caller may have others.
    while (true) {
      siginfo_t info = {};
      if (waitid(P_ALL, 0, &info, WEXITED | WNOWAIT) != 0) return;
      if (running.erase(info.si_pid) == 0) continue;
      (void)waitpid(info.si_pid, nullptr, 0);
      return;
    }
  };
  const auto begin = std::chrono::steady_clock::now();
  for (int k = 0; k < count; ++k) {
    if (static_cast<int>(running.size()) == in_flight) wait_for_one();
    pid_t pid = 0;
    if (const int code = posix_spawn(&pid, arguments[0], nullptr, nullptr, arguments.data(), environ); code != 0)
      return Error{fmt::format("{}: cannot be started: {}", argv[0], std::strerror(code))};
    running.insert(pid);
  }
  while (!running.empty()) wait_for_one();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Result<double> prepared_spawn_seconds(const std::vector<std::string>& argv, int count, const std::vector<int>& cpus) {
  PreparedProcesses prepared(static_cast<int>(cpus.size()));
  SpawnRequest request;
  request.file = argv[0];
  request.argv = argv;
  for (char** entry = environ; *entry != nullptr; ++entry) request.env.emplace_back(*entry);
  std::vector<Spawned> running(cpus.size());
  std::vector<pollfd> ends(cpus.size(), pollfd{-1, POLLIN, 0});
  int started = 0;
  const auto start_on = [&](std::size_t k) -> Status {
    request.cpus = {cpus[k]};
    auto at_hand = prepared.start(request);
    GRANARY_TRY(running[k], at_hand ? Result<Spawned>(std::move(*at_hand)) : spawn(request));
    ends[k].fd = running[k].pidfd;
    ++started;
    return {};
  };
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t k = 0; k < cpus.size() && started < count; ++k) GRANARY_CHECK(start_on(k));
  for (int ended = 0; ended < count;) {
    (void)poll(ends.data(), ends.size(), -1);
    for (std::size_t k = 0; k < ends.size(); ++k) {
      if (ends[k].fd < 0 || ends[k].revents == 0) continue;
      const Spawned over = std::move(running[k]);
      ends[k].fd = -1;
      // The next one first: what is left of this one can wait.
      if (started < count) GRANARY_CHECK(start_on(k));
      (void)reap(over.pidfd);
      close(over.pidfd);
      ++ended;
      if (const auto failure = start_failure(over.child)) return *failure;
    }
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace granary::pilot
