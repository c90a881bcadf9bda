// DIR/endpoint.json: where the pilot of a folder can be reached over TCP. No secrets in it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace granary::pilot {

struct Endpoint {
  std::string host;                    ///< the pilot's host name
  std::vector<std::string> addresses;  ///< to be tried in this order
  std::uint16_t port = 0;              ///< agents and those who ask
  std::uint16_t heart_port = 0;        ///< heartbeats, answered by a thread of their own
};

Status write_endpoint(const std::filesystem::path& dir, const Endpoint& endpoint);
/// Error: there is none, as for a pilot of one machine.
Result<Endpoint> read_endpoint(const std::filesystem::path& dir);

}  // namespace granary::pilot
