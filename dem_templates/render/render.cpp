#include "dem_templates/render/render.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace granary::dem {
namespace {

Error our_error(std::string message) { return Error{std::move(message), Exit::internal}; }

}  // namespace

Result<std::string> render(std::string_view text, std::string_view template_name, const Values& values) {
  std::set<std::string_view> given, used;
  for (const auto& [name, value] : values)
    if (!given.insert(name).second)
      return our_error(fmt::format("{}: the value of @{{{}}} was given twice.", template_name, name));

  std::string filled;
  std::size_t at = 0;
  for (std::size_t open = text.find("@{"); open != std::string_view::npos; open = text.find("@{", at)) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(open), '\n');
    const std::size_t close = text.find('}', open);
    if (close == std::string_view::npos || text.substr(open, close - open).find('\n') != std::string_view::npos)
      return our_error(fmt::format("{}: line {}: a placeholder has no closing brace.", template_name, line));
    const std::string_view name = text.substr(open + 2, close - open - 2);
    const auto value = std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.first == name; });
    if (value == values.end())
      return our_error(
          fmt::format("{}: line {}: there is no value for the placeholder @{{{}}}.", template_name, line, name));
    used.insert(value->first);
    filled += text.substr(at, open - at);
    filled += value->second;
    at = close + 1;
  }
  filled += text.substr(at);

  for (std::string_view name : given)
    if (!used.contains(name))
      return our_error(
          fmt::format("{}: the value \"{}\" is used by no placeholder @{{{}}}.", template_name, name, name));
  return filled;
}

std::string digits(double number) { return fmt::format("{}", number); }

}  // namespace granary::dem
