// Asks the pilot of a folder from another host, over TCP, as ask_pilot() does on its own through the control socket.
#pragma once

#include <filesystem>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::pilot {

/// Blocks. Errors: no endpoint or secret in the folder, nobody there who knows the secret, no answer in time.
Result<json::Value> ask_remote(const std::filesystem::path& dir, const json::Value& request, double timeout_s);

}  // namespace granary::pilot
