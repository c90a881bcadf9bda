#include "pilot/launch/prepared_processes.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <thread>
#include <utility>
#include <vector>

#include "pilot/launch/child.hpp"

namespace granary::pilot {
namespace {

constexpr std::size_t kStackSize = 64 * 1024;

enum Phase : int { making, ready, claimed, taken, dismissed };

void wait_while(std::atomic<int>& phase, int value) {
  while (phase.load() == value) (void)syscall(SYS_futex, &phase, FUTEX_WAIT, value, nullptr, nullptr, 0);
}

void wake(std::atomic<int>& phase) { (void)syscall(SYS_futex, &phase, FUTEX_WAKE, 1, nullptr, nullptr, 0); }

}  // namespace

/// One waiting process, and the thread that has made it. The thread sleeps in clone() until its process has executed a
/// program or is gone: they share what the C library keeps for each thread.
struct PreparedProcesses::Slot {
  std::atomic<int> phase{making};
  std::atomic<bool>* closing = nullptr;
  int owner = 0;  ///< our process
  int pid = 0, pidfd = -1;
  std::uint64_t ticks = 0;  ///< as Spawned::start_ticks; 0: to be asked for
  Child* child = nullptr;   ///< what to execute, once taken
  std::string folder;       ///< where the next task's output is thought to go; empty: nobody knows
  int output = -1;          ///< a file made ahead for it, as a number of the process; -1: none
  char* stack = nullptr;
  std::thread thread;

  static int run(void* argument);
  bool was_taken();
  void keep_one_ready();
};

// In the child: system calls only.
int PreparedProcesses::Slot::run(void* argument) {
  auto* slot = static_cast<Slot*>(argument);
  // Should we be killed, those that wait go with us. (Asked first, in case it happens now.)
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != slot->owner) return 0;
  // Not one of our own files may be held open by it: a lock would outlive us.
  (void)syscall(SYS_close_range, 0U, ~0U, 0U);
  (void)open("/dev/null", O_RDWR);
  (void)dup2(0, 1);
  (void)dup2(0, 2);
  become_group_leader(nullptr);
  // Making a file takes a tenth of a millisecond and more; giving it its name, when the task starts, a fifth of that.
  slot->output = slot->folder.empty() ? -1 : open_nameless(slot->folder);
  slot->pid = getpid();
  if (slot->ticks != boot_ticks()) slot->ticks = 0;
  slot->phase = ready;
  if (*slot->closing) return 0;
  wait_while(slot->phase, ready);
  wait_while(slot->phase, claimed);
  if (slot->phase != taken) return 0;
  (void)prctl(PR_SET_PDEATHSIG, 0);
  return execute(slot->child);
}

/// Of a process that executes its program or is gone. If not, it never got one: dismissed, or killed by somebody.
bool PreparedProcesses::Slot::was_taken() {
  for (int seen = ready; !phase.compare_exchange_strong(seen, making); seen = ready) {
    if (seen != claimed) return seen == taken;
    wait_while(phase, claimed);
  }
  return false;
}

void PreparedProcesses::Slot::keep_one_ready() {
  sigset_t all;
  sigfillset(&all);
  (void)pthread_sigmask(SIG_SETMASK, &all, nullptr);  // no handler of ours may run in the child
  while (!*closing) {
    phase = making;
    ticks = boot_ticks();
    constexpr int kFlags = CLONE_VM | CLONE_VFORK | CLONE_PIDFD | SIGCHLD;
    if (clone(&Slot::run, stack + kStackSize, kFlags, this, &pidfd) < 0) return;
    if (was_taken()) continue;
    (void)reap(pidfd);
    close(pidfd);
  }
}

struct PreparedProcesses::State {
  std::atomic<bool> closing{false};
  std::string last_folder;  ///< of a task's output
  std::vector<std::unique_ptr<Slot>> slots;
};

PreparedProcesses::PreparedProcesses(int count) : state_(std::make_unique<State>()) {
  for (int k = 0; k < count; ++k) {
    auto slot = std::make_unique<Slot>();
    slot->closing = &state_->closing;
    slot->owner = static_cast<int>(getpid());
    void* stack = mmap(nullptr, kStackSize, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK, -1, 0);
    if (stack == MAP_FAILED) return;
    slot->stack = static_cast<char*>(stack);
    slot->thread = std::thread([one = slot.get()] { one->keep_one_ready(); });
    state_->slots.push_back(std::move(slot));
  }
}

PreparedProcesses::~PreparedProcesses() {
  state_->closing = true;
  for (const auto& slot : state_->slots) {
    int waiting = ready;
    if (slot->phase.compare_exchange_strong(waiting, dismissed)) wake(slot->phase);
    slot->thread.join();
    munmap(slot->stack, kStackSize);
  }
}

std::optional<Spawned> PreparedProcesses::start(const SpawnRequest& request) {
  for (const auto& slot : state_->slots) {
    int waiting = ready;
    if (!slot->phase.compare_exchange_strong(waiting, claimed)) continue;
    auto child = std::make_shared<Child>(request);
    child->request.stdin_fd = child->request.stdout_fd = child->request.stderr_fd = 0;  // its /dev/null
    const std::uint64_t ticks = slot->ticks != 0 ? slot->ticks : start_ticks(slot->pid);
    Spawned process{slot->pid, slot->pidfd, ticks, std::move(child)};
    // It wakes up where it is to run: one that moves itself there queues behind what runs. (It tries again itself, and
    // tells if it may not.)
    if (!request.cpus.empty()) (void)sched_setaffinity(slot->pid, sizeof process.child->cpus, &process.child->cpus);
    const std::string folder = request.stdout_file.substr(0, request.stdout_file.rfind('/'));
    if (folder == slot->folder) process.child->spare_output = slot->output;
    // Where each task has a folder of its own, nothing is made ahead.
    slot->folder = folder == state_->last_folder ? folder : "";
    state_->last_folder = folder;
    slot->child = process.child.get();
    (void)kill(slot->pid, SIGCONT);  // somebody may have stopped all that has our name
    slot->phase = taken;
    wake(slot->phase);
    return process;
  }
  return std::nullopt;
}

}  // namespace granary::pilot
