#include "pilot/protocol/channel.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>

#include "common/json/io.hpp"
#include "common/log.hpp"
#include "pilot/protocol/frame.hpp"

namespace granary::pilot {
namespace {

constexpr double kGreetingTime = 10.0;  ///< to prove oneself [s]
/// What one connection may ask of us. Beyond it we read no more until the second is over, and TCP holds the sender
/// back.
constexpr std::size_t kMostBytesPerSecond = 64 << 20;
constexpr std::size_t kMostMessagesPerSecond = 200'000;
/// A peer that does not read what it is sent is as good as gone.
constexpr std::size_t kMostUnsent = 256 << 20;

}  // namespace

struct Channel::State : std::enable_shared_from_this<Channel::State> {
  State(RealLoop& l, int socket, Handshake h, Events e, bool keeps)
      : loop(l), fd(socket), handshake(std::move(h)), events(std::move(e)), keeps_running(keeps) {}

  RealLoop& loop;
  int fd;
  Handshake handshake;
  Events events;
  bool keeps_running;
  FrameReader reader;
  std::optional<FrameWriter> writer;  ///< once it is open
  std::string batch;                  ///< messages of this turn, "[{...},{...}" without its last bracket
  std::string out;                    ///< frames on their way
  bool flush_posted = false, write_waits = false, watched = false;
  bool forsaken = false;  ///< its owner is gone: nobody is to be told anything (the callbacks may be running just now)
  TimerId greeting = TimerId::none, pause = TimerId::none;
  double second = 0.0;  ///< the second of the loop's clock that the counts below are of
  std::size_t bytes = 0, messages = 0;
  int told_dropped = 0;

  void begin() {
    watch();
    greeting = loop.after(kGreetingTime, [this] { close("did not prove itself in time"); });
    if (handshake.is_caller()) write(plain_frame(handshake.first_message()));
  }

  void watch() {
    watched = true;
    loop.watch(
        fd, [self = shared_from_this()] { self->readable(); }, keeps_running);
  }

  void unwatch() {
    if (watched) loop.unwatch(fd);
    watched = false;
  }

  /// Without telling anybody.
  void end() {
    if (fd < 0) return;
    unwatch();
    loop.cancel(greeting);
    loop.cancel(pause);
    ::close(fd);
    fd = -1;
  }

  void close(const std::string& why) {
    if (fd < 0) return;
    end();
    if (!forsaken && events.closed) events.closed(why);
  }

  void readable() {
    const auto self = shared_from_this();  // a callback may destroy the channel
    char buffer[65536];
    const ssize_t n = recv(fd, buffer, sizeof buffer, 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (n <= 0) return close(n == 0 ? "the connection ended" : std::strerror(errno));
    reader.feed({buffer, static_cast<std::size_t>(n)});
    bytes += static_cast<std::size_t>(n);
    while (fd >= 0) {  // a callback may end it
      const auto payload = reader.next();
      if (!payload) break;
      take(*payload);
    }
    tell_dropped();
    if (fd >= 0 && !reader.broken().empty()) return refuse(reader.broken());
    hold_back();
  }

  void take(const std::string& payload) {
    if (!handshake.done()) return greet(payload);
    const auto list = json::parse(payload, "message");
    if (!list || !list->is_array()) return refuse("a message that is no list of objects");
    messages += list->size();
    for (const json::Value& message : list->items()) {
      if (!message.is_object()) return refuse("a message that is no object");
      if (fd >= 0 && !forsaken) events.message(message);
    }
  }

  void greet(const std::string& payload) {
    const auto reply = handshake.take(payload);
    if (!reply) return refuse(reply.error().message);
    if (!reply->empty()) write(plain_frame(*reply));
    if (fd < 0 || !handshake.done()) return;
    loop.cancel(greeting);
    const bool caller = handshake.is_caller();
    reader.expect(caller ? handshake.key_to_caller() : handshake.key_to_answerer());
    writer.emplace(caller ? handshake.key_to_answerer() : handshake.key_to_caller());
    if (events.open) events.open();
  }

  void refuse(const std::string& why) {
    log::warning("protocol", fmt::format("connection of {} closed: {}",
                                         handshake.name().empty() ? "a stranger" : handshake.name(), why));
    close(why);
  }

  void tell_dropped() {
    if (reader.dropped() == told_dropped) return;
    told_dropped = reader.dropped();
    log::warning("protocol",
                 fmt::format("dropped from {}: {} ({} so far)", handshake.name(), reader.last_dropped(), told_dropped));
  }

  void hold_back() {
    if (fd < 0) return;
    if (loop.now() - second >= 1.0) {
      second = loop.now();
      bytes = messages = 0;
    }
    if (bytes <= kMostBytesPerSecond && messages <= kMostMessagesPerSecond) return;
    unwatch();
    write_waits = false;
    pause = loop.after(1.0, [this] {
      watch();
      write("");
    });
  }

  bool send(const json::Value& message) {
    if (!writer || fd < 0) return true;
    const std::string text = json::dump(message);
    if (text.size() + 2 > kLargestPayload) return false;
    if (batch.size() + text.size() + 2 > kLargestPayload) seal_batch();
    batch.append(batch.empty() ? "[" : ",").append(text);
    if (!std::exchange(flush_posted, true)) loop.post([self = shared_from_this()] { self->flush(); });
    return true;
  }

  void seal_batch() {
    if (batch.empty()) return;
    out += writer->seal(batch.append("]"));
    batch.clear();
  }

  void flush() {
    flush_posted = false;
    if (fd < 0) return;
    seal_batch();
    write("");
  }

  void write(const std::string& more) {
    out += more;
    while (!out.empty() && !write_waits) {
      const ssize_t n = ::send(fd, out.data(), out.size(), MSG_NOSIGNAL);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0 && errno == EAGAIN) return wait_to_write();
      if (n < 0) return close_later(std::strerror(errno));
      out.erase(0, static_cast<std::size_t>(n));
    }
    if (out.size() > kMostUnsent) close_later("takes nothing of what it is sent");
  }

  void wait_to_write() {
    if (!watched) return;  // held back: watch() comes later, and the next message writes
    write_waits = true;
    loop.when_writable(fd, [self = shared_from_this()] {
      self->write_waits = false;
      if (self->fd >= 0) self->write("");
    });
  }

  /// Whoever sends need not expect to be told within the call.
  void close_later(const std::string& why) {
    loop.post([self = shared_from_this(), why] { self->close(why); });
  }
};

Channel::Channel(RealLoop& loop, int fd, Handshake handshake, Events events, bool keeps_running)
    : state_(std::make_shared<State>(loop, fd, std::move(handshake), std::move(events), keeps_running)) {
  state_->begin();
}

Channel::~Channel() { close(); }

void Channel::close() {
  state_->forsaken = true;
  state_->end();
}

bool Channel::send(const json::Value& message) { return state_->send(message); }
Role Channel::role() const { return state_->handshake.role(); }
const std::string& Channel::name() const { return state_->handshake.name(); }

}  // namespace granary::pilot
