#include "common/json/value.hpp"

#include <limits>

#include "common/assert.hpp"

namespace granary::json {

Value::Value(const std::vector<double>& items) : content_(Array(items.begin(), items.end())) {}
Value::Value(const std::vector<std::vector<double>>& rows) : content_(Array(rows.begin(), rows.end())) {}
Value::Value(const std::vector<std::string>& items) : content_(Array(items.begin(), items.end())) {}

Value Value::object(std::initializer_list<Member> members) {
  Value made;
  made.content_ = Object{std::vector<Member>(members)};
  return made;
}

bool Value::Object::operator==(const Object& other) const { return members == other.members; }
bool Value::operator==(const Value& other) const { return content_ == other.content_; }

bool Value::as_bool() const {
  GRANARY_ASSERT(is_bool());
  return std::get<bool>(content_);
}

std::int64_t Value::as_integer() const {
  GRANARY_ASSERT(is_integer());
  return std::get<std::int64_t>(content_);
}

double Value::as_number() const {
  if (is_integer()) return static_cast<double>(std::get<std::int64_t>(content_));
  GRANARY_ASSERT(is_number());
  return std::get<double>(content_);
}

const std::string& Value::as_string() const {
  GRANARY_ASSERT(is_string());
  return std::get<std::string>(content_);
}

const Array& Value::items() const {
  GRANARY_ASSERT(is_array());
  return std::get<Array>(content_);
}
Array& Value::items() { return std::get<Array>(content_); }

const std::vector<Member>& Value::members() const {
  GRANARY_ASSERT(is_object());
  return std::get<Object>(content_).members;
}
std::vector<Member>& Value::members() { return std::get<Object>(content_).members; }

const Value* Value::find(std::string_view key) const {
  if (!is_object()) return nullptr;
  for (const auto& [name, value] : members())
    if (name == key) return &value;
  return nullptr;
}

Value* Value::find(std::string_view key) { return const_cast<Value*>(std::as_const(*this).find(key)); }

const Value& Value::operator[](std::string_view key) const {
  static const Value none;
  const Value* found = find(key);
  return found != nullptr ? *found : none;
}

Value& Value::set(std::string key, Value value) {
  if (is_null()) content_ = Object{};
  if (Value* found = find(key)) {
    *found = std::move(value);
  } else {
    members().emplace_back(std::move(key), std::move(value));
  }
  return *this;
}

Value& Value::push(Value value) {
  if (is_null()) content_ = Array{};
  items().push_back(std::move(value));
  return *this;
}

std::size_t Value::size() const {
  if (is_array()) return items().size();
  if (is_object()) return members().size();
  return 0;
}

const Array& Value::items_or_none() const {
  static const Array none;
  return is_array() ? items() : none;
}

const std::vector<Member>& Value::members_or_none() const {
  static const std::vector<Member> none;
  return is_object() ? members() : none;
}

double Value::number_or(std::string_view key, double otherwise) const {
  const Value* found = find(key);
  return found != nullptr && found->is_number() ? found->as_number() : otherwise;
}

std::int64_t Value::integer_or(std::string_view key, std::int64_t otherwise) const {
  const Value* found = find(key);
  return found != nullptr && found->is_integer() ? found->as_integer() : otherwise;
}

std::string Value::text_or(std::string_view key, std::string otherwise) const {
  const Value* found = find(key);
  return found != nullptr && found->is_string() ? found->as_string() : std::move(otherwise);
}

std::vector<double> Value::numbers(std::string_view key) const { return (*this)[key].numbers(); }

std::vector<double> Value::numbers() const {
  std::vector<double> values;
  if (!is_array()) return values;
  for (const Value& item : items())
    values.push_back(item.is_number() ? item.as_number() : std::numeric_limits<double>::quiet_NaN());
  return values;
}

}  // namespace granary::json
