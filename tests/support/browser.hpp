// A headless Chromium with one page, asked over its debugging pipe (DevTools protocol: JSON ended by a zero byte, on
// the descriptors 3 and 4). --dump-dom takes the page as it is when loaded; this one can wait for what events bring.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <vector>

#include "common/json/io.hpp"

namespace granary::test {

class Browser {
 public:
  /// `profile`: a folder of its own.
  Browser(const std::string& profile, const std::string& url) {
    int to[2], from[2];
    if (pipe2(to, O_CLOEXEC) != 0 || pipe2(from, O_CLOEXEC) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      setpgid(0, 0);
      const int read_end = fcntl(to[0], F_DUPFD, 10), write_end = fcntl(from[1], F_DUPFD, 10);
      dup2(read_end, 3);
      dup2(write_end, 4);
      dup2(::open("/dev/null", O_WRONLY), STDERR_FILENO);
      const std::string folder = "--user-data-dir=" + profile;
      execlp("chromium", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync", folder.c_str(),
             "--remote-debugging-pipe", "about:blank", nullptr);
      _exit(127);
    }
    close(to[0]);
    close(from[1]);
    to_ = to[1];
    from_ = from[0];
    const std::string target = call("Target.createTarget", json::Value::object({{"url", url}})).text_or("targetId", "");
    session_ = call("Target.attachToTarget", json::Value::object({{"targetId", target}, {"flatten", true}}))
                   .text_or("sessionId", "");
  }
  ~Browser() {
    if (pid_ > 0) {
      kill(-pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    close(to_);
    close(from_);
  }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  bool open() const { return !session_.empty(); }
  /// What an expression of JavaScript gives in the page, as text.
  std::string value(const std::string& expression) {
    return call("Runtime.evaluate", json::Value::object({{"expression", "String(" + expression + ")"}}))["result"]
        .text_or("value", "");
  }
  /// Asks until the expression is true; false if it does not become so.
  bool becomes(const std::string& expression, double seconds = 15.0) {
    const auto until = Clock::now() + std::chrono::duration<double>(seconds);
    while (value(expression) != "true") {
      if (Clock::now() > until) return false;
      usleep(100'000);
    }
    return true;
  }

 private:
  using Clock = std::chrono::steady_clock;

  /// The result of a command; null if none comes within 20 s. Events in between are passed over.
  json::Value call(const std::string& method, const json::Value& parameters) {
    json::Value message = json::Value::object({{"id", ++id_}, {"method", method}, {"params", parameters}});
    if (!session_.empty()) message.set("sessionId", session_);
    const std::string text = json::dump(message) + '\0';
    if (write(to_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) return {};
    for (const auto until = Clock::now() + std::chrono::seconds(20); Clock::now() < until;) {
      const auto end = in_.find('\0');
      if (end != std::string::npos) {
        const auto answer = json::parse(in_.substr(0, end), "the browser's answer");
        in_.erase(0, end + 1);
        if (answer && answer->integer_or("id", 0) == id_) return (*answer)["result"];
        continue;
      }
      pollfd readable{from_, POLLIN, 0};
      char buffer[65536];
      if (poll(&readable, 1, 1000) <= 0) continue;
      const ssize_t n = read(from_, buffer, sizeof buffer);
      if (n <= 0) return {};
      in_.append(buffer, static_cast<std::size_t>(n));
    }
    return {};
  }

  pid_t pid_ = -1;
  int to_ = -1, from_ = -1, id_ = 0;
  std::string in_, session_;
};

}  // namespace granary::test
