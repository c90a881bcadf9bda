// A JSON value as plain data. Parsing and printing (and the library that does it) are in json/io.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace granary::json {

class Value;
using Array = std::vector<Value>;
using Member = std::pair<std::string, Value>;

/// Object members keep the order they were written in: what a person reads back is what they wrote.
class Value {
 public:
  Value() = default;
  Value(std::nullptr_t) {}                                                  // NOLINT: implicit on purpose, as all below
  Value(bool value) : content_(value) {}                                    // NOLINT
  Value(double value) : content_(value) {}                                  // NOLINT
  Value(int value) : content_(std::int64_t{value}) {}                       // NOLINT
  Value(std::int64_t value) : content_(value) {}                            // NOLINT
  Value(std::size_t value) : content_(static_cast<std::int64_t>(value)) {}  // NOLINT
  Value(std::string value) : content_(std::move(value)) {}                  // NOLINT
  Value(std::string_view value) : content_(std::string(value)) {}           // NOLINT
  Value(const char* value) : content_(std::string(value)) {}                // NOLINT
  Value(Array items) : content_(std::move(items)) {}                        // NOLINT
  Value(const std::vector<double>& items);                                  // NOLINT
  Value(const std::vector<std::vector<double>>& rows);                      // NOLINT
  Value(const std::vector<std::string>& items);                             // NOLINT

  static Value object(std::initializer_list<Member> members = {});
  static Value array() { return Value(Array{}); }

  bool is_null() const { return std::holds_alternative<std::monostate>(content_); }
  bool is_bool() const { return std::holds_alternative<bool>(content_); }
  bool is_integer() const { return std::holds_alternative<std::int64_t>(content_); }
  bool is_number() const { return is_integer() || std::holds_alternative<double>(content_); }
  bool is_string() const { return std::holds_alternative<std::string>(content_); }
  bool is_array() const { return std::holds_alternative<Array>(content_); }
  bool is_object() const { return std::holds_alternative<Object>(content_); }

  // The caller has asked is_...() first; a wrong type is our own mistake (asserted).
  bool as_bool() const;
  std::int64_t as_integer() const;
  double as_number() const;
  const std::string& as_string() const;
  const Array& items() const;
  Array& items();
  const std::vector<Member>& members() const;
  std::vector<Member>& members();

  /// The member of that name; nullptr if there is none or this is not an object.
  const Value* find(std::string_view key) const;
  Value* find(std::string_view key);
  /// The member of that name; a null value if there is none.
  const Value& operator[](std::string_view key) const;
  /// Sets (or replaces) a member; makes a null value an object first. Returns *this for chaining.
  Value& set(std::string key, Value value);
  /// Appends to an array; makes a null value an array first.
  Value& push(Value value);
  std::size_t size() const;

  /// The items or members; none if this is of another kind.
  const Array& items_or_none() const;
  const std::vector<Member>& members_or_none() const;

  // For files of our own making, where a missing member just takes the default.
  double number_or(std::string_view key, double otherwise) const;
  std::int64_t integer_or(std::string_view key, std::int64_t otherwise) const;
  std::string text_or(std::string_view key, std::string otherwise) const;
  /// The numbers of an array member; empty if there is none. null items are NaN.
  std::vector<double> numbers(std::string_view key) const;
  std::vector<double> numbers() const;

  bool operator==(const Value& other) const;

 private:
  struct Object {
    std::vector<Member> members;
    bool operator==(const Object& other) const;
  };
  std::variant<std::monostate, bool, std::int64_t, double, std::string, Array, Object> content_;
};

}  // namespace granary::json
