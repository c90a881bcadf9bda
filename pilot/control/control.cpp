#include "pilot/control/control.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>

#include "common/json/io.hpp"
#include "common/log.hpp"
#include "pilot/control/run_lock.hpp"
#include "pilot/control/unix_socket.hpp"
#include "pilot/protocol/ask_remote.hpp"
#include "pilot/protocol/endpoint.hpp"
#include "pilot/protocol/tcp.hpp"

namespace granary::pilot {
namespace {

constexpr std::size_t kMostConnections = 64;
constexpr double kLongestSilence = 10.0;  ///< a connection that says nothing for so long is closed [s]

json::Value refusal(const std::string& why) { return json::Value::object({{"error", why}}); }

}  // namespace

struct ControlServer::State {
  struct Connection {
    std::string in, out;
    bool closing = false;  ///< once `out` is written
    TimerId silence = TimerId::none;
  };

  RealLoop& loop;
  std::filesystem::path dir;
  Answer answer;
  int listener = -1;
  std::map<int, Connection> connections;

  ~State() {
    while (!connections.empty()) drop(connections.begin()->first);
    if (listener < 0) return;
    loop.unwatch(listener);
    close(listener);
    unlink((dir / "control.sock").c_str());
  }

  void accept_one() {
    const int fd = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    const int uid = peer_uid(fd);
    if ((uid != static_cast<int>(geteuid()) && uid != 0) || connections.size() >= kMostConnections) {
      log::warning("pilot", fmt::format("control.sock: refused a connection of user {}", uid));
      close(fd);
      return;
    }
    connections.emplace(fd, Connection{});
    loop.watch(
        fd, [this, fd] { readable(fd); }, false);
    listen_on(fd);
  }

  void listen_on(int fd) {
    Connection& connection = connections.at(fd);
    loop.cancel(connection.silence);
    connection.silence = loop.after(kLongestSilence, [this, fd] { drop(fd); });
  }

  void drop(int fd) {
    const auto found = connections.find(fd);
    if (found == connections.end()) return;
    loop.cancel(found->second.silence);
    loop.unwatch(fd);
    close(fd);
    connections.erase(found);
  }

  void readable(int fd) {
    char buffer[16384];
    const ssize_t n = recv(fd, buffer, sizeof buffer, 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (n <= 0) return drop(fd);
    Connection& connection = connections.at(fd);
    if (connection.closing) return;
    connection.in.append(buffer, static_cast<std::size_t>(n));
    listen_on(fd);
    for (std::size_t end; (end = connection.in.find('\n')) != std::string::npos;) {
      const std::string line = connection.in.substr(0, end);
      connection.in.erase(0, end + 1);
      reply(connection, line);
    }
    if (connection.in.size() > kLargestMessage) {
      connection.out += json::dump(refusal(fmt::format("a message is at most {} bytes", kLargestMessage))) + "\n";
      connection.closing = true;
    }
    write_out(fd);
  }

  void reply(Connection& connection, const std::string& line) {
    const auto request = json::parse(line, "request");
    const json::Value value = request ? answer(*request) : refusal(request.error().message);
    connection.out += json::dump(value) + "\n";
  }

  void write_out(int fd) {
    const auto found = connections.find(fd);
    if (found == connections.end()) return;
    Connection& connection = found->second;
    while (!connection.out.empty()) {
      const ssize_t n = send(fd, connection.out.data(), connection.out.size(), MSG_NOSIGNAL);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0 && errno == EAGAIN) return loop.when_writable(fd, [this, fd] { write_out(fd); });
      if (n < 0) return drop(fd);
      connection.out.erase(0, static_cast<std::size_t>(n));
    }
    if (connection.closing) drop(fd);
  }
};

ControlServer::ControlServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
ControlServer::ControlServer(ControlServer&&) noexcept = default;
ControlServer& ControlServer::operator=(ControlServer&&) noexcept = default;
ControlServer::~ControlServer() = default;

Result<ControlServer> ControlServer::listen(RealLoop& loop, const std::filesystem::path& dir, Answer answer) {
  GRANARY_TRY(const int listener, listen_at(dir));
  std::unique_ptr<State> state(new State{loop, dir, std::move(answer), listener, {}});
  loop.watch(
      listener, [s = state.get()] { s->accept_one(); }, false);
  return ControlServer(std::move(state));
}

namespace {

/// Whether the pilot of the folder is, or was last, one of several nodes on another host than ours.
bool is_elsewhere(const std::filesystem::path& dir) {
  const auto endpoint = read_endpoint(dir);
  return endpoint && endpoint->host != host_name();
}

Result<json::Value> without_error(json::Value answer) {
  if (const json::Value* error = answer.find("error"); error != nullptr && error->is_string())
    return Error{error->as_string()};
  return answer;
}

}  // namespace

bool pilot_is_alive(const std::filesystem::path& dir) {
  if (folder_is_locked(dir)) return true;
  // Not every shared file system tells one host of another's locks.
  return is_elsewhere(dir) && ask_remote(dir, json::Value::object({{"ask", "status"}}), 3.0).has_value();
}

Result<json::Value> ask_pilot(const std::filesystem::path& dir, const json::Value& request, double timeout_s) {
  if (is_elsewhere(dir)) {
    GRANARY_TRY(json::Value answer, ask_remote(dir, request, timeout_s));
    return without_error(std::move(answer));
  }
  const int fd = connect_to(dir);
  if (fd < 0) {
    if (errno == ENOENT || errno == ECONNREFUSED || errno == ENOTDIR) {
      return Error{fmt::format("{}: no pilot is running on this folder. `granary resume {}` goes on with it.",
                               dir.string(), dir.string())};
    }
    return Error{fmt::format("{}/control.sock: cannot connect: {}", dir.string(), std::strerror(errno))};
  }
  const std::string line = json::dump(request) + "\n";
  std::string text;
  bool said = send(fd, line.data(), line.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(line.size());
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(timeout_s);
  while (said && (text.empty() || text.back() != '\n')) {
    const double left = std::chrono::duration<double>(deadline - Clock::now()).count();
    pollfd wait{fd, POLLIN, 0};
    const int ready = poll(&wait, 1, left > 0.0 ? static_cast<int>(left * 1e3) + 1 : 0);
    if (ready < 0 && errno == EINTR) continue;
    char buffer[65536];
    const ssize_t n = ready > 0 ? recv(fd, buffer, sizeof buffer, 0) : 0;
    if (n <= 0) said = false;
    if (n > 0) text.append(buffer, static_cast<std::size_t>(n));
  }
  close(fd);
  if (!said) {
    return Error{
        fmt::format("{}: the pilot did not answer within {:g} s (it refuses other users, and may just be ending)",
                    dir.string(), timeout_s),
        Exit::internal};
  }
  text.pop_back();
  GRANARY_TRY(json::Value answer, json::parse(text, "answer"));
  return without_error(std::move(answer));
}

}  // namespace granary::pilot
