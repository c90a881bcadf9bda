#include "pilot/protocol/ask_remote.hpp"

#include <fmt/format.h>

#include <optional>

#include "pilot/protocol/channel.hpp"
#include "pilot/protocol/endpoint.hpp"
#include "pilot/protocol/tcp.hpp"

namespace granary::pilot {

Result<json::Value> ask_remote(const std::filesystem::path& dir, const json::Value& request, double timeout_s) {
  GRANARY_TRY(const Endpoint endpoint, read_endpoint(dir));
  GRANARY_TRY(const Digest secret, read_secret(dir));
  GRANARY_TRY(const int fd, connect_tcp(endpoint.addresses, endpoint.port, timeout_s));
  RealLoop loop;
  std::optional<json::Value> answer;
  std::string why = fmt::format("no answer within {:g} s", timeout_s);
  std::optional<Channel> channel;
  channel.emplace(loop, fd, Handshake::call(secret, Role::client, host_name()),
                  Channel::Events{[&] { channel->send(request); },
                                  [&](const json::Value& message) {
                                    answer = message;
                                    loop.stop();
                                  },
                                  [&](const std::string& reason) {
                                    why = reason;
                                    loop.stop();
                                  }});
  loop.after(timeout_s, [&] { loop.stop(); });
  loop.run();
  if (!answer) return Error{fmt::format("{}: the pilot on {}: {}", dir.string(), endpoint.host, why), Exit::internal};
  return *std::move(answer);
}

}  // namespace granary::pilot
