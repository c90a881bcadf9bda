#include "pilot/launch/spawn_limit.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <set>

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

}  // namespace granary::pilot
