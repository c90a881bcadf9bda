// A program that runs beside the test, on a pipe or on a terminal of its own; ended with the test.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

namespace granary::test {

class Background {
 public:
  enum class On { pipe, terminal };

  /// stdout (on a terminal also stderr and stdin) is what output() gives; "A=b" in `environment` is set for it.
  Background(std::vector<std::string> argv, On on = On::pipe, const std::vector<std::string>& environment = {}) {
    int ends[2] = {-1, -1};
    winsize size = {};
    size.ws_row = 30;
    size.ws_col = 100;
    if (on == On::pipe && pipe2(ends, O_CLOEXEC) != 0) return;
    pid_ = on == On::terminal ? forkpty(&fd_, nullptr, nullptr, &size) : fork();
    if (pid_ == 0) {
      if (on == On::pipe) dup2(ends[1], STDOUT_FILENO);
      for (const std::string& variable : environment)
        setenv(variable.substr(0, variable.find('=')).c_str(), variable.substr(variable.find('=') + 1).c_str(), 1);
      std::vector<char*> words;
      for (std::string& word : argv) words.push_back(word.data());
      words.push_back(nullptr);
      execvp(words[0], words.data());
      _exit(127);
    }
    if (on == On::pipe) {
      close(ends[1]);
      fd_ = ends[0];
    }
  }
  ~Background() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    if (fd_ >= 0) close(fd_);
  }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  pid_t pid() const { return pid_; }
  int fd() const { return fd_; }
  void signal(int number) const { kill(pid_, number); }
  void resize(unsigned short columns, unsigned short rows) const {
    winsize size = {};
    size.ws_row = rows;
    size.ws_col = columns;
    ioctl(fd_, TIOCSWINSZ, &size);
  }
  void type(const std::string& keys) const { (void)!write(fd_, keys.data(), keys.size()); }

  const std::string& output() const { return output_; }
  void forget() { output_.clear(); }
  /// Reads until `text` has come; false if it does not within `seconds`, or the program has closed its output.
  bool says(const std::string& text, double seconds = 10.0) {
    return wait([&] { return output_.find(text) != std::string::npos; }, seconds);
  }
  /// Reads to the end; the exit code, 128 + the signal that ended it, -1 if it does not end.
  int exit_code(double seconds = 20.0) {
    wait([] { return false; }, seconds);
    int status = 0;
    const auto until = Clock::now() + std::chrono::duration<double>(seconds);
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      if (Clock::now() > until) return -1;
      usleep(5000);
    }
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  using Clock = std::chrono::steady_clock;

  template <class Done>
  bool wait(Done done, double seconds) {
    const auto until = Clock::now() + std::chrono::duration<double>(seconds);
    while (!done()) {
      const double left = std::chrono::duration<double>(until - Clock::now()).count();
      pollfd readable{fd_, POLLIN, 0};
      if (left <= 0.0 || poll(&readable, 1, static_cast<int>(left * 1e3) + 1) <= 0) return false;
      char buffer[65536];
      const ssize_t n = read(fd_, buffer, sizeof buffer);
      if (n <= 0) return done();
      output_.append(buffer, static_cast<std::size_t>(n));
    }
    return true;
  }

  pid_t pid_ = -1;
  int fd_ = -1;
  std::string output_;
};

}  // namespace granary::test
