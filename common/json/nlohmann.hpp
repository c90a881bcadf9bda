// Our values to the library's and back. Only for the .cpp files of common/json.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/json/value.hpp"

namespace granary::json::detail {

using Library = nlohmann::ordered_json;

inline Value from_library(const Library& source) {
  switch (source.type()) {
    case Library::value_t::boolean:
      return source.get<bool>();
    case Library::value_t::number_integer:
      return source.get<std::int64_t>();
    case Library::value_t::number_unsigned:
      // Beyond int64 only a double can hold it.
      if (source.get<std::uint64_t>() > INT64_MAX) return source.get<double>();
      return source.get<std::int64_t>();
    case Library::value_t::number_float:
      return source.get<double>();
    case Library::value_t::string:
      return source.get<std::string>();
    case Library::value_t::array: {
      Array items;
      items.reserve(source.size());
      for (const Library& item : source) items.push_back(from_library(item));
      return items;
    }
    case Library::value_t::object: {
      Value made = Value::object();
      for (const auto& [key, value] : source.items()) made.members().emplace_back(key, from_library(value));
      return made;
    }
    default:
      return {};
  }
}

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
    for (const auto& [key, value] : source.members()) made[key] = to_library(value);
    return made;
  }
  return nullptr;
}

}  // namespace granary::json::detail
