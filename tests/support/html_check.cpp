#include "tests/support/html_check.hpp"

#include <regex>
#include <set>
#include <vector>

namespace granary::test {
namespace {

std::string near(std::string_view page, std::size_t at) { return std::string(page.substr(at, 60)); }

std::string unbalanced_tag(std::string_view page) {
  std::vector<std::string> open;
  for (std::size_t at = page.find('<'); at != std::string_view::npos; at = page.find('<', at + 1)) {
    const std::size_t end = page.find('>', at);
    if (end == std::string_view::npos) return "a tag without end: " + near(page, at);
    const std::string_view tag = page.substr(at + 1, end - at - 1);
    if (tag.starts_with("!doctype") || tag.ends_with("/") || tag.starts_with("meta")) continue;
    if (tag.starts_with("!") || tag.starts_with("?")) return "not of an HTML page: " + near(page, at);
    if (!tag.starts_with("/")) {
      open.emplace_back(tag.substr(0, tag.find_first_of(" \n\t\r")));
    } else if (open.empty() || open.back() != tag.substr(1)) {
      return "closed but not open: " + near(page, at);
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : "never closed: " + open.back();
}

}  // namespace

std::string what_is_wrong_with_html(std::string_view page) {
  if (auto wrong = unbalanced_tag(page); !wrong.empty()) return wrong;

  std::set<std::string> ids;
  const std::regex id(R"(\sid=["']([^"']*)["'])"), link(R"(href=["']#([^"']*)["']|url\(#([^)]*)\))");
  using Matches = std::cregex_iterator;
  for (Matches match(page.data(), page.data() + page.size(), id); match != Matches(); ++match)
    if (!ids.insert((*match)[1]).second) return "id twice: " + (*match)[1].str();
  for (Matches match(page.data(), page.data() + page.size(), link); match != Matches(); ++match)
    if (const std::string target = (*match)[1].matched ? (*match)[1] : (*match)[2]; !ids.contains(target))
      return "no target: " + target;
  return "";
}

}  // namespace granary::test
