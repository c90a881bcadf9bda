#include "pilot/launch/marked.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <memory>

namespace granary::pilot {
namespace {

using Folder = std::unique_ptr<DIR, int (*)(DIR*)>;

/// The numbers that are names of entries of /proc or /proc/PID/task.
std::vector<int> numbered_entries(const std::string& folder) {
  std::vector<int> numbers;
  const Folder entries(opendir(folder.c_str()), &closedir);
  if (!entries) return numbers;
  while (const dirent* entry = readdir(entries.get())) {
    char* end = nullptr;
    const long number = std::strtol(entry->d_name, &end, 10);
    if (end != entry->d_name && *end == '\0') numbers.push_back(static_cast<int>(number));
  }
  return numbers;
}

std::string contents(const std::string& file) {
  std::string text;
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return text;
  char buffer[16384];
  for (ssize_t n; (n = read(fd, buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
  close(fd);
  return text;
}

bool is_ours(int pid) {
  struct stat status = {};
  return stat(fmt::format("/proc/{}", pid).c_str(), &status) == 0 && (status.st_uid == geteuid() || geteuid() == 0);
}

}  // namespace

std::vector<int> processes_with(std::string_view entry_begins) {
  std::vector<int> pids;
  for (const int pid : numbered_entries("/proc")) {
    if (pid == getpid() || !is_ours(pid)) continue;
    // A zombie's environment reads as empty.
    const std::string environment = contents(fmt::format("/proc/{}/environ", pid));
    for (std::size_t at = 0; at < environment.size(); at = environment.find('\0', at) + 1) {
      if (environment.compare(at, entry_begins.size(), entry_begins) == 0) {
        pids.push_back(pid);
        break;
      }
      if (environment.find('\0', at) == std::string::npos) break;
    }
  }
  return pids;
}

std::vector<int> marked_processes(const std::string& mark) {
  // With the end of the entry: one mark may be the beginning of another.
  return processes_with(fmt::format("{}={}", kMarkVariable, mark) + '\0');
}

bool end_processes_with(std::string_view entry_begins) {
  constexpr int kLooks = 400;
  constexpr useconds_t kPause = 5000;  // [us]; nobody forks faster than this
  for (int look = 0; look < kLooks; ++look) {
    const std::vector<int> pids = processes_with(entry_begins);
    if (pids.empty()) return look > 0;
    for (const int pid : pids) ::kill(pid, SIGKILL);
    usleep(kPause);
  }
  return true;
}

void signal_marked(const std::string& mark, int signal) {
  for (const int pid : marked_processes(mark)) ::kill(pid, signal);
}

void pin_marked(const std::string& mark, const std::vector<int>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : cpus) CPU_SET(cpu, &set);
  for (const int pid : marked_processes(mark)) {
    for (const int thread : numbered_entries(fmt::format("/proc/{}/task", pid)))
      (void)sched_setaffinity(thread, sizeof set, &set);
  }
}

}  // namespace granary::pilot
