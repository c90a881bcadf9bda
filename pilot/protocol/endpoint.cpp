#include "pilot/protocol/endpoint.hpp"

#include <fmt/format.h>

#include "common/json/io.hpp"

namespace granary::pilot {
namespace {

std::filesystem::path file_in(const std::filesystem::path& dir) { return dir / "endpoint.json"; }

std::uint16_t port_in(const json::Value& value, const char* key) {
  const std::int64_t port = value.integer_or(key, 0);
  return port > 0 && port < 65536 ? static_cast<std::uint16_t>(port) : std::uint16_t{0};
}

}  // namespace

Status write_endpoint(const std::filesystem::path& dir, const Endpoint& endpoint) {
  return json::write_file(file_in(dir), json::Value::object({{"host", endpoint.host},
                                                             {"addresses", endpoint.addresses},
                                                             {"port", int{endpoint.port}},
                                                             {"heart_port", int{endpoint.heart_port}}}));
}

Result<Endpoint> read_endpoint(const std::filesystem::path& dir) {
  GRANARY_TRY(const json::Value value, json::read_file(file_in(dir)));
  Endpoint endpoint{value.text_or("host", ""), {}, port_in(value, "port"), port_in(value, "heart_port")};
  for (const json::Value& address : value["addresses"].items_or_none())
    if (address.is_string()) endpoint.addresses.push_back(address.as_string());
  if (endpoint.port == 0 || endpoint.addresses.empty())
    return Error{fmt::format("{}: names no address and port.", file_in(dir).string())};
  return endpoint;
}

}  // namespace granary::pilot
