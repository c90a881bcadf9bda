#include "pilot/protocol/handshake.hpp"

namespace granary::pilot {
namespace {

constexpr std::string_view kVersion = "granary-1";
constexpr std::size_t kNonce = sizeof(Digest);
constexpr std::size_t kLongestName = 255;

Error refusal(const char* what) { return {what}; }

}  // namespace

Handshake Handshake::call(const Digest& secret, Role role, std::string name) {
  Handshake one(secret, true);
  name.resize(std::min(name.size(), kLongestName));
  one.role_ = role;
  one.hello_.append(kVersion).append(1, static_cast<char>(role)).append(bytes_of(random_digest())).append(name);
  one.name_ = std::move(name);
  return one;
}

Handshake Handshake::answer(const Digest& secret) { return Handshake(secret, false); }

Result<std::string> Handshake::take(std::string_view message) {
  if (done_) return refusal("a greeting after the greeting");
  if (!is_caller_ && hello_.empty()) return take_hello(message);
  if (!is_caller_) {
    if (!same_digest(message, bytes_of(proof("caller")))) return refusal("a caller that does not know the secret");
    done_ = true;
    return std::string();
  }
  if (message.size() != kNonce + sizeof(Digest)) return refusal("no greeting of ours");
  nonce_ = message.substr(0, kNonce);
  if (!same_digest(message.substr(kNonce), bytes_of(proof("answerer"))))
    return refusal("an answerer that does not know the secret");
  done_ = true;
  return std::string(bytes_of(proof("caller")));
}

Result<std::string> Handshake::take_hello(std::string_view message) {
  const std::size_t head = kVersion.size() + 1 + kNonce;
  if (message.size() <= head || message.size() > head + kLongestName || !message.starts_with(kVersion))
    return refusal("no greeting of this version of Granary");
  const char role = message[kVersion.size()];
  if (role != 'a' && role != 'h' && role != 'c') return refusal("a greeting of no known role");
  role_ = static_cast<Role>(role);
  name_ = message.substr(head);
  hello_ = message;
  nonce_ = bytes_of(random_digest());
  return nonce_ + std::string(bytes_of(proof("answerer")));
}

}  // namespace granary::pilot
