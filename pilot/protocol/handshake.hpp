// Two sides prove to each other that they know the campaign's secret, without sending it. Pure.
//
//   caller    -> "granary-1", role, caller's nonce, name
//   answerer  -> its nonce, HMAC(secret; "answerer", caller's message, its nonce)
//   caller    -> HMAC(secret; "caller", its message, answerer's nonce)
//
// The keys of the two directions come from the secret and both nonces: nothing of an earlier connection fits this one.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/result.hpp"
#include "pilot/protocol/secret.hpp"

namespace granary::pilot {

/// What a caller wants: take tasks, be watched, or ask as through the control socket.
enum class Role : char { agent = 'a', heart = 'h', client = 'c' };

class Handshake {
 public:
  /// `name`: of the node, or of who asks; 1 to 255 bytes (cut).
  static Handshake call(const Digest& secret, Role role, std::string name);
  static Handshake answer(const Digest& secret);

  /// What the caller sends first; "" for the answerer.
  std::string first_message() const { return is_caller_ ? hello_ : ""; }
  /// Takes the other's next message and gives the reply ("": none). Error: it is not what it must be.
  Result<std::string> take(std::string_view message);

  /// Both sides have proved themselves. Only then what follows.
  bool done() const { return done_; }
  Digest key_to_answerer() const { return key("to answerer"); }
  Digest key_to_caller() const { return key("to caller"); }
  bool is_caller() const { return is_caller_; }
  Role role() const { return role_; }
  const std::string& name() const { return name_; }

 private:
  explicit Handshake(const Digest& secret, bool is_caller) : secret_(secret), is_caller_(is_caller) {}
  Digest proof(std::string_view whose) const { return hmac(secret_, {whose, hello_, nonce_}); }
  Digest key(std::string_view direction) const { return hmac(secret_, {direction, hello_, nonce_}); }
  Result<std::string> take_hello(std::string_view message);

  Digest secret_;
  bool is_caller_;
  bool done_ = false;
  Role role_ = Role::client;
  std::string name_;
  std::string hello_;  ///< the caller's first message
  std::string nonce_;  ///< the answerer's
};

}  // namespace granary::pilot
