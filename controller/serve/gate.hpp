// Which requests are answered at all. Pure.
// Whoever knows the URL may look: its first part is a random token. The Host header must name an address of ours, so
// that no other web site can reach us under a name of its own (DNS rebinding).
#pragma once

#include <string>
#include <string_view>
#include <variant>

namespace granary::serve {

/// What there is to get.
enum class Place { page, script, style, view, events };

struct Refusal {
  unsigned status = 403;  ///< of HTTP
  std::string why;
};

struct Gate {
  std::string token;    ///< 32 hex digits
  std::string address;  ///< that is listened on: "127.0.0.1"

  /// @param host  of the request's header, with or without a port; "" if it has none
  std::variant<Place, Refusal> admit(std::string_view method, std::string_view target, std::string_view host) const;
};

/// 128 bits from the system's random source, as hex.
std::string new_token();

}  // namespace granary::serve
