#include "pilot/launch/spawn.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/close_range.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <mutex>
#include <utility>

#include "pilot/launch/child.hpp"

namespace granary::pilot {
namespace {

int fail(Child* child, Stage stage) {
  if (child != nullptr && child->failed == Stage::none) {
    child->failed = stage;
    child->code = errno;
  }
  return 127;
}

constexpr int kOutputFlags = O_WRONLY | O_APPEND | O_CLOEXEC;

/// -1: it cannot be opened.
int open_output(const std::string& file) { return open(file.c_str(), kOutputFlags | O_CREAT | O_TRUNC, 0644); }

/// False: there is a file of this name already, or it cannot be done here.
bool give_name(int nameless, const std::string& file) {
  // The first way takes a privilege, or Linux 6.10; the second takes the number that open_nameless() gave.
  return linkat(nameless, "", AT_FDCWD, file.c_str(), AT_EMPTY_PATH) == 0 ||
         linkat(AT_FDCWD, "/proc/self/fd/3", AT_FDCWD, file.c_str(), AT_SYMLINK_FOLLOW) == 0;
}

int stdout_of(const Child& child) {
  const std::string& file = child.request.stdout_file;
  if (file.empty()) return child.request.stdout_fd;
  return child.spare_output >= 0 && give_name(child.spare_output, file) ? child.spare_output : open_output(file);
}

int null_device() {
  static const int fd = open("/dev/null", O_RDWR | O_CLOEXEC);
  return fd;
}

int run_child(void* argument) {
  auto* child = static_cast<Child*>(argument);
  become_group_leader(child);
  return execute(child);
}

/// A stack for children, used by one at a time: the parent sleeps until the child has executed its program.
void* child_stack_top() {
  constexpr std::size_t kSize = 64 * 1024;
  static void* const stack =
      mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK, -1, 0);
  return stack == MAP_FAILED ? nullptr : static_cast<char*>(stack) + kSize;
}

std::vector<char*> pointers(const std::vector<std::string>& texts) {
  std::vector<char*> list;
  list.reserve(texts.size() + 1);
  for (const std::string& text : texts) list.push_back(const_cast<char*>(text.c_str()));
  list.push_back(nullptr);
  return list;
}

}  // namespace

Child::Child(SpawnRequest wanted)
    : request(std::move(wanted)), argv(pointers(request.argv)), env(pointers(request.env)) {
  CPU_ZERO(&cpus);
  for (const int cpu : request.cpus) CPU_SET(cpu, &cpus);
  for (int* fd : {&request.stdin_fd, &request.stdout_fd, &request.stderr_fd})
    if (*fd < 0) *fd = null_device();
}

void become_group_leader(Child* child) {
  struct sigaction standard = {};
  standard.sa_handler = SIG_DFL;
  for (int signal = 1; signal < 32; ++signal) (void)sigaction(signal, &standard, nullptr);
  // No session of its own: with automatic task groups each would be scheduled as a user by itself, made and unmade with
  // it.
  if (setpgid(0, 0) < 0) (void)fail(child, Stage::group);
}

int open_nameless(const std::string& folder) { return open(folder.c_str(), kOutputFlags | O_TMPFILE, 0644); }

int execute(Child* child) {
  const SpawnRequest& request = child->request;
  if (child->failed != Stage::none) return 127;
  if (!request.cpus.empty() && sched_setaffinity(0, sizeof child->cpus, &child->cpus) != 0)
    return fail(child, Stage::affinity);
  if (request.background) {
    const sched_param usual = {};
    (void)sched_setscheduler(0, SCHED_OTHER, &usual);  // ours may be a real-time one
    (void)!nice(19);
  }
  if (!request.dir.empty() && chdir(request.dir.c_str()) != 0) return fail(child, Stage::folder);
  const int out = stdout_of(*child);
  const bool same = request.stderr_file == request.stdout_file && !request.stdout_file.empty();
  const int err = same ? out : request.stderr_file.empty() ? request.stderr_fd : open_output(request.stderr_file);
  if (out < 0 || err < 0) return fail(child, Stage::output);
  if (dup2(request.stdin_fd, 0) < 0 || dup2(out, 1) < 0 || dup2(err, 2) < 0) return fail(child, Stage::files);
  // Whatever a library of ours has left open is none of the program's business.
  (void)syscall(SYS_close_range, 3U, ~0U, CLOSE_RANGE_CLOEXEC);
  sigset_t none;
  sigemptyset(&none);
  (void)sigprocmask(SIG_SETMASK, &none, nullptr);
  execve(request.file.c_str(), child->argv.data(), child->env.data());
  return fail(child, Stage::execute);
}

std::uint64_t boot_ticks() {
  timespec time = {};
  (void)clock_gettime(CLOCK_BOOTTIME, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 100U + static_cast<std::uint64_t>(time.tv_nsec) / 10'000'000U;
}

Error spawn_error(const SpawnRequest& request, Stage stage, int code) {
  const std::string why = std::strerror(code);
  switch (stage) {
    case Stage::affinity: {
      std::string cpus;
      for (const int cpu : request.cpus) cpus += fmt::format("{}{}", cpus.empty() ? "" : ",", cpu);
      return {fmt::format("{}: cannot be pinned to CPU(s) {}: {}", request.file, cpus, why), Exit::task_failed};
    }
    case Stage::folder:
      return {fmt::format("{}: the working folder cannot be entered: {}", request.dir, why), Exit::task_failed};
    case Stage::output: {
      std::string files = request.stdout_file;
      if (request.stderr_file != files) files += (files.empty() ? "" : " or ") + request.stderr_file;
      return {fmt::format("{}: cannot be opened for the task's output: {}", files, why), Exit::task_failed};
    }
    case Stage::execute:
      return {fmt::format("{}: cannot be executed: {}", request.file, why), Exit::task_failed};
    default:
      return {fmt::format("{}: cannot be started: {}", request.file, why), Exit::task_failed};
  }
}

Result<Spawned> spawn(const SpawnRequest& request) {
  Child child(request);
  static std::mutex one_at_a_time;  // threads share the stack of the child
  const std::scoped_lock lock(one_at_a_time);
  void* stack = child_stack_top();
  if (stack == nullptr) return spawn_error(request, Stage::none, ENOMEM);

  // No handler of ours may run in the child while it shares our memory.
  sigset_t all, before;
  sigfillset(&all);
  (void)pthread_sigmask(SIG_SETMASK, &all, &before);
  int pidfd = -1;
  const std::uint64_t tick_before = boot_ticks();
  const int pid = clone(run_child, stack, CLONE_VM | CLONE_VFORK | CLONE_PIDFD | SIGCHLD, &child, &pidfd);
  const int code = errno;
  (void)pthread_sigmask(SIG_SETMASK, &before, nullptr);

  if (pid < 0) return spawn_error(request, Stage::none, code);
  if (child.failed != Stage::none) {
    (void)reap(pidfd);
    close(pidfd);
    return spawn_error(request, child.failed, child.code);
  }
  // It was made between two readings of the clock that the kernel stamps it with. Only if a tick lies between them,
  // its file in /proc must be read, which takes longer than all the rest: it waits for the new program to be loaded.
  const std::uint64_t tick = boot_ticks();
  return Spawned{pid, pidfd, tick == tick_before ? tick : start_ticks(pid), nullptr};
}

std::optional<Error> start_failure(const std::shared_ptr<Child>& child) {
  if (!child || child->failed == Stage::none) return std::nullopt;
  return spawn_error(child->request, child->failed, child->code);
}

ProcessEnd reap(int pidfd) {
  siginfo_t info = {};
  rusage usage = {};
  // The C library's waitid() does not pass the resource usage on.
  while (syscall(SYS_waitid, P_PIDFD, pidfd, &info, WEXITED, &usage) != 0) {
    if (errno != EINTR) return {};
  }
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  ProcessEnd end;
  end.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  if (info.si_code == CLD_EXITED) {
    end.exit_code = info.si_status;
  } else {
    end.signal = info.si_status;
  }
  return end;
}

std::uint64_t start_ticks(int pid) {
  const int fd = open(fmt::format("/proc/{}/stat", pid).c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return 0;
  char text[1024];
  const ssize_t n = read(fd, text, sizeof text - 1);
  close(fd);
  if (n <= 0) return 0;
  text[n] = '\0';
  // The second field, the name in brackets, may hold spaces: count from behind its last bracket, which ends field 2.
  const char* at = std::strrchr(text, ')');
  for (int field = 2; at != nullptr && field < 22; ++field) at = std::strchr(at + 1, ' ');
  return at == nullptr ? 0 : std::strtoull(at + 1, nullptr, 10);
}

}  // namespace granary::pilot
