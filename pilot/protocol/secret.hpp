// A campaign's secret: whoever can read DIR/secret (mode 0600) may speak to its pilot. It never stands on a command
// line, in an environment or in a message; what is sent are proofs of knowing it.
#pragma once

#include <array>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace granary::pilot {

using Digest = std::array<unsigned char, 32>;

/// HMAC-SHA256 of the parts, one behind the other. Source: RFC 2104, by OpenSSL.
Digest hmac(const Digest& key, std::initializer_list<std::string_view> parts);
/// Compares without telling by its duration where two digests differ.
bool same_digest(std::string_view a, std::string_view b);
/// From the system's random source.
Digest random_digest();
inline std::string_view bytes_of(const Digest& digest) {
  return {reinterpret_cast<const char*>(digest.data()), digest.size()};
}

/// The secret of a campaign's folder; made by the first who asks.
Result<Digest> campaign_secret(const std::filesystem::path& dir);
/// Errors: there is none; it is another user's, or others may read it (then it is none).
Result<Digest> read_secret(const std::filesystem::path& dir);

/// Tells the campaign's processes from others'; 16 hex digits that give nothing of the secret away.
std::string campaign_tag(const Digest& secret);

}  // namespace granary::pilot
