#include "controller/campaign/pointer.hpp"

#include <charconv>

namespace granary::campaign {

std::vector<std::string> steps_of(const std::string& pointer) {
  std::vector<std::string> steps;
  for (std::size_t at = 0; at < pointer.size(); ++at) {
    if (pointer[at] == '/') {
      steps.emplace_back();
    } else if (steps.empty()) {
      return {};
    } else if (pointer[at] == '~' && at + 1 < pointer.size() && (pointer[at + 1] == '0' || pointer[at + 1] == '1')) {
      steps.back() += pointer[++at] == '0' ? '~' : '/';
    } else {
      steps.back() += pointer[at];
    }
  }
  return steps;
}

std::string with_step(const std::string& pointer, const std::string& step) {
  std::string longer = pointer + "/";
  for (const char c : step) longer += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return longer;
}

long index_of(const std::string& step, std::size_t size) {
  if (step == "-") return static_cast<long>(size);
  long index = -1;
  const auto [end, code] = std::from_chars(step.data(), step.data() + step.size(), index);
  const bool whole = code == std::errc{} && end == step.data() + step.size() && index >= 0;
  return whole && index <= static_cast<long>(size) ? index : -1;
}

const json::Value* find(const json::Value& document, const std::string& pointer) {
  const json::Value* at = &document;
  for (const std::string& step : steps_of(pointer)) {
    if (at->is_array()) {
      const long index = index_of(step, at->size());
      if (index < 0 || index >= static_cast<long>(at->size())) return nullptr;
      at = &at->items()[static_cast<std::size_t>(index)];
    } else {
      at = at->find(step);
    }
    if (at == nullptr) return nullptr;
  }
  return at;
}

bool is_within(const std::string& place, const std::string& outer) {
  return place == outer || (place.size() > outer.size() && place.starts_with(outer) && place[outer.size()] == '/');
}

}  // namespace granary::campaign
