#include "controller/serve/server.hpp"

#include <fmt/format.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <csignal>
#include <optional>
#include <set>

#include "controller/serve/gate.hpp"
#include "controller/serve/page_text.hpp"

namespace granary::serve {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using Code = boost::system::error_code;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::chrono::seconds kPatience{10};   ///< for a request, and for a reader of ours to take what we write
constexpr std::chrono::seconds kKeepAlive{15};  ///< a comment now and then finds readers that have gone
constexpr std::size_t kLongestHeader = 8192;    ///< [bytes]

// Nothing from elsewhere, no frames, no referrer that gives the token away, nothing kept.
constexpr std::string_view kSafety =
    "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src "
    "data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n"
    "Cache-Control: no-store\r\n"
    "Connection: close\r\n";

std::string head(unsigned status, std::string_view type, std::optional<std::size_t> length) {
  std::string text = fmt::format("HTTP/1.1 {} {}\r\nContent-Type: {}\r\n{}", status,
                                 std::string(http::obsolete_reason(static_cast<http::status>(status))), type, kSafety);
  if (length) text += fmt::format("Content-Length: {}\r\n", *length);
  return text + "\r\n";
}

std::string whole(unsigned status, std::string_view type, std::string_view body) {
  return head(status, type, body.size()) + std::string(body);
}

}  // namespace

struct Server::State {
  struct Connection;

  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  asio::signal_set signals{io, SIGINT, SIGTERM};
  asio::steady_timer timer{io};
  Gate gate;
  Clock::duration period{};
  std::function<std::string()> view;
  std::set<std::shared_ptr<Connection>> connections, watching;  ///< all; those that follow the events
  std::string last;                                             ///< the view told last
  Clock::time_point told{};

  void accept();
  void look();
  void tell(const std::string& event);
  void drop(const std::shared_ptr<Connection>& connection);
};

/// One request, and then for the events whatever happens.
struct Server::State::Connection : std::enable_shared_from_this<Connection> {
  Connection(State& state, tcp::socket socket) : server(state), stream(std::move(socket)) {
    parser.header_limit(kLongestHeader);
  }

  State& server;
  beast::tcp_stream stream;
  beast::flat_buffer buffer{2 * kLongestHeader};
  http::request_parser<http::empty_body> parser;
  std::string out, next;  ///< being written; to be written after it, the newest only
  bool writing = false, closing = false;

  void begin() {
    stream.expires_after(kPatience);
    http::async_read(stream, buffer, parser, [self = shared_from_this()](Code error, std::size_t) {
      if (error) return self->server.drop(self);
      self->answer();
    });
  }

  void answer() {
    const auto& request = parser.get();
    const auto admitted = server.gate.admit(std::string(request.method_string()), std::string(request.target()),
                                            std::string(request[http::field::host]));
    if (const auto* refusal = std::get_if<Refusal>(&admitted))
      return finish(whole(refusal->status, "text/plain; charset=utf-8", refusal->why + "\n"));
    switch (std::get<Place>(admitted)) {
      case Place::page:
        return finish(whole(200, "text/html; charset=utf-8", assets::page));
      case Place::script:
        return finish(whole(200, "text/javascript; charset=utf-8", assets::script));
      case Place::style:
        return finish(whole(200, "text/css; charset=utf-8", assets::style));
      case Place::view:
        return finish(whole(200, "application/json", server.view() + "\n"));
      case Place::events:
        return follow();
    }
  }

  void finish(std::string text) {
    closing = true;
    say(std::move(text));
  }

  void follow() {
    stream.expires_never();
    // Nothing more is asked on this connection: the read ends when the reader goes away.
    stream.async_read_some(buffer.prepare(1),
                           [self = shared_from_this()](Code, std::size_t) { self->server.drop(self); });
    server.watching.insert(shared_from_this());
    say(head(200, "text/event-stream", std::nullopt) + "retry: 2000\n\n");
    server.last.clear();  // a newcomer is told at once, and the others with it
    server.look();
  }

  /// A reader that is slower than we are misses views, not the newest one.
  void say(std::string text) {
    if (writing) {
      next = std::move(text);
      return;
    }
    writing = true;
    out = std::move(text);
    stream.expires_after(kPatience);
    asio::async_write(stream, asio::buffer(out), [self = shared_from_this()](Code error, std::size_t) {
      self->writing = false;
      if (error || self->closing) return self->server.drop(self);
      self->stream.expires_never();
      if (!self->next.empty()) self->say(std::exchange(self->next, {}));
    });
  }
};

void Server::State::accept() {
  acceptor.async_accept([this](Code error, tcp::socket socket) {
    if (!acceptor.is_open()) return;
    if (!error && static_cast<int>(connections.size()) >= kMostConnections) {
      // Said without waiting, to whoever can take it at once.
      Code ignored;
      socket.non_blocking(true, ignored);
      const std::string text = whole(503, "text/plain; charset=utf-8", "too many connections\n");
      socket.write_some(asio::buffer(text), ignored);
      socket.shutdown(tcp::socket::shutdown_send, ignored);
    } else if (!error) {
      const auto connection = std::make_shared<Connection>(*this, std::move(socket));
      connections.insert(connection);
      connection->begin();
    }
    accept();
  });
}

void Server::State::look() {
  timer.cancel();
  if (watching.empty()) return;
  const std::string now = view();
  if (now != last) {
    last = now;
    tell("event: view\ndata: " + now + "\n\n");
  } else if (Clock::now() - told > kKeepAlive) {
    tell(": still here\n\n");
  }
  timer.expires_after(period);
  timer.async_wait([this](Code error) {
    if (!error) look();
  });
}

void Server::State::tell(const std::string& event) {
  told = Clock::now();
  for (const auto& connection : watching) connection->say(event);
}

void Server::State::drop(const std::shared_ptr<Connection>& connection) {
  watching.erase(connection);
  if (connections.erase(connection) == 0) return;
  Code ignored;
  connection->stream.socket().shutdown(tcp::socket::shutdown_both, ignored);
  connection->stream.close();
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}
Server::Server(Server&&) noexcept = default;
Server& Server::operator=(Server&&) noexcept = default;
Server::~Server() = default;

Result<Server> Server::open(const ServerOptions& options, std::function<std::string()> view) {
  Code error;
  const auto address = asio::ip::make_address(options.address, error);
  if (error || address.is_unspecified())
    return Error{
        fmt::format("--address {}: must be one address of this machine, such as 127.0.0.1 (any at once would let "
                    "other web sites in under names of their own).",
                    options.address)};
  auto state = std::make_unique<State>();
  const tcp::endpoint endpoint(address, static_cast<std::uint16_t>(options.port));
  state->acceptor.open(endpoint.protocol(), error);
  if (!error) state->acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) state->acceptor.bind(endpoint, error);
  if (!error) state->acceptor.listen(kMostConnections, error);
  if (error)
    return Error{fmt::format("{}:{}: cannot listen there: {}. Leave --port out for any that is free.", options.address,
                             options.port, error.message())};
  state->gate = {new_token(), address.is_v6() ? "[" + address.to_string() + "]" : address.to_string()};
  state->period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options.period));
  state->view = std::move(view);
  return Server(std::move(state));
}

int Server::port() const { return state_->acceptor.local_endpoint().port(); }
std::string Server::url() const {
  return fmt::format("http://{}:{}/{}/", state_->gate.address, port(), state_->gate.token);
}

void Server::run() {
  State& state = *state_;
  state.signals.async_wait([&state](Code, int) { state.io.stop(); });
  state.accept();
  state.io.run();
}

}  // namespace granary::serve
