// JSON text on one line, written and read back without detours: a journal has millions of short lines, all of our own
// making. Files of users go through json/io, which says where they are wrong.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/value.hpp"

namespace granary::json {

/// Appends the value on one line. Numbers read back to the same bits; NaN and infinities become null.
void append(std::string& text, const Value& value);
void append(std::string& text, std::string_view value);
inline void append(std::string& text, const std::string& value) { append(text, std::string_view(value)); }
inline void append(std::string& text, const char* value) { append(text, std::string_view(value)); }
void append(std::string& text, double value);
void append(std::string& text, std::int64_t value);
inline void append(std::string& text, int value) { append(text, std::int64_t{value}); }
inline void append(std::string& text, bool value) { text += value ? "true" : "false"; }
void append(std::string& text, const std::vector<std::string>& items);

/// An object written member by member, with the calls that would fill a Value; closed at the end of its life.
class TextObject {
 public:
  explicit TextObject(std::string& text) : text_(text) {}
  TextObject(const TextObject&) = delete;
  TextObject& operator=(const TextObject&) = delete;
  ~TextObject() { text_ += before_ == '{' ? "{}" : "}"; }

  template <class T>
  TextObject& set(std::string_view key, const T& value) {
    append(member(key), value);
    return *this;
  }
  /// The text, for the caller to append this member's value to.
  std::string& member(std::string_view key);

 private:
  std::string& text_;
  char before_ = '{';
};

/// The value of a text that append() (or any JSON writer) wrote; nothing if it is not JSON.
std::optional<Value> parse_text(std::string_view text);

}  // namespace granary::json
