// Our values to the library's. Only for the .cpp files of common/json.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/json/value.hpp"

namespace granary::json::detail {

using Library = nlohmann::ordered_json;

inline Library to_library(const Value& source) {
  if (source.is_bool()) return source.as_bool();
  if (source.is_integer()) return source.as_integer();
  if (source.is_number()) return std::isfinite(source.as_number()) ? Library(source.as_number()) : Library(nullptr);
  if (source.is_string()) return source.as_string();
  if (source.is_array()) {
    Library made = Library::array();
    for (const Value& item : source.items()) made.push_back(to_library(item));
    return made;
  }
  if (source.is_object()) {
    Library made = Library::object();
    // Ours have no key twice: the library need not look.
    auto& members = made.get_ref<Library::object_t&>();
    for (const auto& [key, value] : source.members())
      members.Library::object_t::Container::emplace_back(key, to_library(value));
    return made;
  }
  return nullptr;
}

}  // namespace granary::json::detail
