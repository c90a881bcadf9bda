#include "controller/serve/gate.hpp"

#include <fmt/format.h>

#include "pilot/protocol/secret.hpp"

namespace granary::serve {

namespace {

/// "localhost:8080" -> "localhost", "[::1]:80" -> "[::1]".
std::string_view without_port(std::string_view host) {
  const auto colon = host.rfind(':');
  const auto bracket = host.rfind(']');
  if (colon == std::string_view::npos || (bracket != std::string_view::npos && bracket > colon)) return host;
  return host.substr(0, colon);
}

}  // namespace

std::variant<Place, Refusal> Gate::admit(std::string_view method, std::string_view target,
                                         std::string_view host) const {
  // Any port: behind an ssh tunnel the browser sees another one than ours.
  const std::string_view name = without_port(host);
  if (name != "localhost" && name != "127.0.0.1" && name != "[::1]" && name != address)
    return Refusal{421, "this page answers under its own address only"};
  const bool has_token = target.size() > token.size() + 1 && target[0] == '/' && target[token.size() + 1] == '/' &&
                         pilot::same_digest(target.substr(1, token.size()), token);
  if (!has_token) return Refusal{403, "the address lacks the right token; `granary serve` printed the whole"};
  if (method != "GET") return Refusal{405, "there is nothing but GET here"};
  std::string_view rest = target.substr(token.size() + 2);
  rest = rest.substr(0, rest.find('?'));
  if (rest.empty()) return Place::page;
  if (rest == "page.js") return Place::script;
  if (rest == "page.css") return Place::style;
  if (rest == "view.json") return Place::view;
  if (rest == "events") return Place::events;
  return Refusal{404, "there is no such page"};
}

std::string new_token() {
  const pilot::Digest random = pilot::random_digest();
  std::string token;
  for (std::size_t k = 0; k < 16; ++k) token += fmt::format("{:02x}", random[k]);
  return token;
}

}  // namespace granary::serve
