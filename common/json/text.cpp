#include "common/json/text.hpp"

#include <charconv>
#include <cmath>

namespace granary::json {
namespace {

constexpr int kDeepest = 64;  ///< nesting; ours is below 6

void append_code_point(std::string& text, unsigned code) {
  const auto byte = [&](unsigned value) { text += static_cast<char>(value); };
  if (code < 0x80) {
    byte(code);
  } else if (code < 0x800) {
    byte(0xc0 | code >> 6U);
    byte(0x80 | (code & 0x3fU));
  } else if (code < 0x10000) {
    byte(0xe0 | code >> 12U);
    byte(0x80 | (code >> 6U & 0x3fU));
    byte(0x80 | (code & 0x3fU));
  } else {
    byte(0xf0 | code >> 18U);
    byte(0x80 | (code >> 12U & 0x3fU));
    byte(0x80 | (code >> 6U & 0x3fU));
    byte(0x80 | (code & 0x3fU));
  }
}

class Parser {
 public:
  explicit Parser(std::string_view text) : at_(text.data()), end_(text.data() + text.size()) {}

  std::optional<Value> whole() {
    Value value;
    if (!read(value, 0)) return std::nullopt;
    skip_space();
    return at_ == end_ ? std::optional(std::move(value)) : std::nullopt;
  }

 private:
  void skip_space() {
    while (at_ != end_ && (*at_ == ' ' || *at_ == '\t' || *at_ == '\r' || *at_ == '\n')) ++at_;
  }
  bool take(char wanted) {
    skip_space();
    if (at_ == end_ || *at_ != wanted) return false;
    ++at_;
    return true;
  }
  bool take(std::string_view word) {
    if (!std::string_view(at_, static_cast<std::size_t>(end_ - at_)).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }

  bool read(Value& value, int depth) {
    skip_space();
    if (at_ == end_ || depth > kDeepest) return false;
    switch (*at_) {
      case '{':
        return read_object(value, depth);
      case '[':
        return read_array(value, depth);
      case '"': {
        std::string text;
        if (!read_string(text)) return false;
        value = Value(std::move(text));
        return true;
      }
      case 't':
        value = Value(true);
        return take("true");
      case 'f':
        value = Value(false);
        return take("false");
      case 'n':
        value = Value();
        return take("null");
      default:
        return read_number(value);
    }
  }

  bool read_object(Value& value, int depth) {
    ++at_;
    value = Value::object();
    if (take('}')) return true;
    std::vector<Member>& members = value.members();
    do {
      Member& member = members.emplace_back();
      skip_space();
      if (!read_string(member.first) || !take(':') || !read(member.second, depth + 1)) return false;
    } while (take(','));
    return take('}');
  }

  bool read_array(Value& value, int depth) {
    ++at_;
    value = Value::array();
    if (take(']')) return true;
    Array& items = value.items();
    do {
      if (!read(items.emplace_back(), depth + 1)) return false;
    } while (take(','));
    return take(']');
  }

  bool read_number(Value& value) {
    const char* stop = at_;
    bool whole = true;
    for (; stop != end_ && (std::isdigit(static_cast<unsigned char>(*stop)) != 0 || *stop == '-' || *stop == '+' ||
                            *stop == '.' || *stop == 'e' || *stop == 'E');
         ++stop)
      whole = whole && *stop != '.' && *stop != 'e' && *stop != 'E';
    if (whole) {
      std::int64_t number = 0;
      const auto read = std::from_chars(at_, stop, number);
      if (read.ec != std::errc() || read.ptr != stop) return false;
      value = Value(number);
    } else {
      double number = 0.0;
      const auto read = std::from_chars(at_, stop, number);
      if (read.ec != std::errc() || read.ptr != stop) return false;
      value = Value(number);
    }
    at_ = stop;
    return true;
  }

  bool read_hex(unsigned& code) {
    if (end_ - at_ < 4) return false;
    const auto read = std::from_chars(at_, at_ + 4, code, 16);
    const bool good = read.ec == std::errc() && read.ptr == at_ + 4;
    at_ += 4;
    return good;
  }

  bool read_escape(std::string& text) {
    if (at_ == end_) return false;
    const char kind = *at_++;
    constexpr std::string_view kFrom = "\"\\/bfnrt", kTo = "\"\\/\b\f\n\r\t";
    if (const std::size_t k = kFrom.find(kind); k != std::string_view::npos) {
      text += kTo[k];
      return true;
    }
    unsigned code = 0, low = 0;
    if (kind != 'u' || !read_hex(code)) return false;
    if (code >= 0xd800 && code < 0xdc00) {
      if (!take("\\u") || !read_hex(low) || low < 0xdc00 || low >= 0xe000) return false;
      code = 0x10000 + ((code - 0xd800) << 10U) + (low - 0xdc00);
    }
    append_code_point(text, code);
    return true;
  }

  bool read_string(std::string& text) {
    if (at_ == end_ || *at_ != '"') return false;
    ++at_;
    while (at_ != end_) {
      const char* plain = at_;
      while (at_ != end_ && *at_ != '"' && *at_ != '\\') ++at_;
      text.append(plain, at_);
      if (at_ == end_) return false;
      if (*at_++ == '"') return true;
      if (!read_escape(text)) return false;
    }
    return false;
  }

  const char *at_, *end_;
};

}  // namespace

void append(std::string& text, std::int64_t value) {
  char digits[24];
  const auto end = std::to_chars(digits, digits + sizeof digits, value);
  text.append(digits, end.ptr);
}

void append(std::string& text, double value) {
  if (!std::isfinite(value)) {
    text += "null";
    return;
  }
  char digits[40];
  const auto end = std::to_chars(digits, digits + sizeof digits, value);
  const std::string_view number(digits, static_cast<std::size_t>(end.ptr - digits));
  text += number;
  if (number.find_first_of(".e") == std::string_view::npos) text += ".0";  // stays a number with a fraction
}

void append(std::string& text, std::string_view value) {
  constexpr char kHex[] = "0123456789abcdef";
  text += '"';
  const char* plain = value.data();
  const char* const end = value.data() + value.size();
  for (const char* at = plain; at != end; ++at) {
    const auto c = static_cast<unsigned char>(*at);
    if (c >= 0x20 && c != '"' && c != '\\') continue;
    text.append(plain, at);
    plain = at + 1;
    if (c == '"' || c == '\\') {
      text += '\\';
      text += *at;
    } else if (c == '\n') {
      text += "\\n";
    } else {
      text += "\\u00";
      text += kHex[c / 16];
      text += kHex[c % 16];
    }
  }
  text.append(plain, end);
  text += '"';
}

void append(std::string& text, const std::vector<std::string>& items) {
  char before = '[';
  for (const std::string& item : items) {
    text += std::exchange(before, ',');
    append(text, std::string_view(item));
  }
  text += before == '[' ? "[]" : "]";
}

void append(std::string& text, const Value& value) {
  if (value.is_string()) {
    append(text, std::string_view(value.as_string()));
  } else if (value.is_integer()) {
    append(text, value.as_integer());
  } else if (value.is_number()) {
    append(text, value.as_number());
  } else if (value.is_bool()) {
    text += value.as_bool() ? "true" : "false";
  } else if (value.is_array()) {
    char before = '[';
    for (const Value& item : value.items()) {
      text += std::exchange(before, ',');
      append(text, item);
    }
    text += before == '[' ? "[]" : "]";
  } else if (value.is_object()) {
    char before = '{';
    for (const auto& [key, member] : value.members()) {
      text += std::exchange(before, ',');
      append(text, std::string_view(key));
      text += ':';
      append(text, member);
    }
    text += before == '{' ? "{}" : "}";
  } else {
    text += "null";
  }
}

std::string& TextObject::member(std::string_view key) {
  text_ += std::exchange(before_, ',');
  append(text_, key);
  text_ += ':';
  return text_;
}

std::optional<Value> parse_text(std::string_view text) { return Parser(text).whole(); }

}  // namespace granary::json
