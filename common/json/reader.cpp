#include "common/json/reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "common/json/io.hpp"
#include "common/units.hpp"

namespace granary::json {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A value as a message shows it: whole if short.
std::string shown(const Value& value) {
  std::string text = dump(value);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

/// RFC 6901: "~" and "/" inside a key are escaped.
std::string escaped(const std::string& key) {
  std::string text;
  for (const char c : key) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return text;
}

}  // namespace

bool Range::contains(double x) const {
  if (std::isnan(x)) return false;
  const bool above = low_included ? x >= low : x > low;
  const bool below = high_included ? x <= high : x < high;
  return above && below;
}

std::string Range::text() const {
  if (low == -kInfinity && high == kInfinity) return "any number";
  if (high == kInfinity) return fmt::format("{} {:g}", low_included ? ">=" : ">", low);
  if (low == -kInfinity) return fmt::format("{} {:g}", high_included ? "<=" : "<", high);
  return fmt::format("in {}{:g}, {:g}{}", low_included ? "[" : "(", low, high, high_included ? "]" : ")");
}

std::string Range::clause() const { return low == -kInfinity && high == kInfinity ? "" : ", " + text(); }

Reader::Reader(const Value& value, std::string file, Problems& problems, std::string pointer)
    : value_(&value), file_(std::move(file)), problems_(&problems), pointer_(std::move(pointer)) {
  static const Value empty = Value::object();
  if (value_->is_object()) return;
  if (!value_->is_null() || pointer_.empty())
    problems_->add({file_, pointer_, shown(*value_), "it must be an object, {...}.", ""});
  value_ = &empty;
}

std::string Reader::pointer(const std::string& key) const { return pointer_ + "/" + escaped(key); }

const Value* Reader::wanted(const std::string& key, bool required) {
  asked_.push_back(key);
  const Value* found = value_->find(key);
  if (found == nullptr && required) problems_->add({file_, pointer(key), "", "it is missing and must be given.", ""});
  return found;
}

const Value* Reader::raw(const std::string& key) { return wanted(key, false); }
bool Reader::has(const std::string& key) { return wanted(key, false) != nullptr; }

void Reader::wrong_type(const std::string& key, const Value& value, const std::string& wanted) {
  problems_->add({file_, pointer(key), shown(value), "it must be " + wanted + ".", ""});
}

void Reader::problem(const std::string& key, std::string message, std::string hint) {
  const Value* found = value_->find(key);
  problems_->add({file_, pointer(key), found != nullptr ? shown(*found) : "", std::move(message), std::move(hint)});
}

double Reader::number(const std::string& key, Range range) {
  return wanted(key, true) == nullptr ? 0.0 : number_or(key, 0.0, range);
}

double Reader::number_or(const std::string& key, double otherwise, Range range) {
  const Value* found = wanted(key, false);
  if (found == nullptr) return otherwise;
  if (!found->is_number()) return wrong_type(key, *found, "a number without a unit" + range.clause()), otherwise;
  if (!range.contains(found->as_number())) return problem(key, "it must be " + range.text() + "."), otherwise;
  return found->as_number();
}

std::int64_t Reader::integer(const std::string& key, Range range) {
  return wanted(key, true) == nullptr ? 0 : integer_or(key, 0, range);
}

std::int64_t Reader::integer_or(const std::string& key, std::int64_t otherwise, Range range) {
  const Value* found = wanted(key, false);
  if (found == nullptr) return otherwise;
  if (!found->is_integer()) return wrong_type(key, *found, "a whole number" + range.clause()), otherwise;
  if (!range.contains(found->as_number())) return problem(key, "it must be " + range.text() + "."), otherwise;
  return found->as_integer();
}

bool Reader::boolean_or(const std::string& key, bool otherwise) {
  const Value* found = wanted(key, false);
  if (found == nullptr) return otherwise;
  if (!found->is_bool()) return wrong_type(key, *found, "true or false"), otherwise;
  return found->as_bool();
}

std::string Reader::text(const std::string& key) { return wanted(key, true) == nullptr ? "" : text_or(key, ""); }

std::string Reader::text_or(const std::string& key, std::string otherwise) {
  const Value* found = wanted(key, false);
  if (found == nullptr) return otherwise;
  if (!found->is_string()) return wrong_type(key, *found, "a text in quotes"), otherwise;
  return found->as_string();
}

std::string Reader::choice(const std::string& key, const std::vector<std::string>& allowed) {
  return wanted(key, true) == nullptr ? allowed.front() : choice_or(key, allowed.front(), allowed);
}

std::string Reader::choice_or(const std::string& key, std::string otherwise, const std::vector<std::string>& allowed) {
  const Value* found = wanted(key, false);
  if (found == nullptr) return otherwise;
  const std::string list = fmt::format("{}", fmt::join(allowed, ", "));
  if (!found->is_string()) return wrong_type(key, *found, "one of: " + list), otherwise;
  const std::string& written = found->as_string();
  if (std::find(allowed.begin(), allowed.end(), written) != allowed.end()) return written;
  const std::string near = did_you_mean(written, allowed);
  problem(key, "it must be one of: " + list + ".", near.empty() ? "" : "Did you mean \"" + near + "\"?");
  return otherwise;
}

double Reader::quantity(const std::string& key, const std::string& si_unit, Range range) {
  return wanted(key, true) == nullptr ? 0.0 : quantity_or(key, 0.0, si_unit, range);
}

double Reader::quantity_or(const std::string& key, double otherwise_si, const std::string& si_unit, Range range) {
  const Value* found = wanted(key, false);
  if (found == nullptr) return otherwise_si;
  if (!found->is_string())
    return wrong_type(key, *found, fmt::format("a number with a unit in quotes, such as \"1 {}\"", si_unit)),
           otherwise_si;
  const auto si = to_si(found->as_string(), si_unit);
  if (!si) return problem(key, si.error().message), otherwise_si;
  if (!range.contains(*si)) return problem(key, fmt::format("it must be {} {}.", range.text(), si_unit)), otherwise_si;
  return *si;
}

std::vector<double> Reader::quantities(const std::string& key, const std::string& si_unit, Range range) {
  std::vector<double> values;
  const Value* found = wanted(key, true);
  if (found == nullptr) return values;
  if (!found->is_array()) return wrong_type(key, *found, "a list of numbers with units in quotes"), values;
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Value& item = found->items()[i];
    const std::string place = fmt::format("{}/{}", pointer(key), i);
    if (!item.is_string()) {
      problems_->add({file_, place, shown(item),
                      fmt::format("it must be a number with a unit in quotes, such as \"1 {}\".", si_unit), ""});
    } else if (const auto si = to_si(item.as_string(), si_unit); !si) {
      problems_->add({file_, place, shown(item), si.error().message, ""});
    } else if (!range.contains(*si)) {
      problems_->add({file_, place, shown(item), fmt::format("it must be {} {}.", range.text(), si_unit), ""});
    } else {
      values.push_back(*si);
    }
  }
  return values;
}

std::vector<double> Reader::numbers(const std::string& key, Range range) {
  std::vector<double> values;
  const Value* found = wanted(key, true);
  if (found == nullptr) return values;
  if (!found->is_array()) return wrong_type(key, *found, "a list of numbers"), values;
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Value& item = found->items()[i];
    if (item.is_number() && range.contains(item.as_number())) {
      values.push_back(item.as_number());
    } else {
      problems_->add({file_, fmt::format("{}/{}", pointer(key), i), shown(item),
                      "it must be a number" + range.clause() + ".", ""});
    }
  }
  return values;
}

std::vector<std::string> Reader::texts_or(const std::string& key, std::vector<std::string> otherwise) {
  const Value* found = wanted(key, false);
  if (found == nullptr) return otherwise;
  const auto is_text = [](const Value& item) { return item.is_string(); };
  if (!found->is_array() || !std::all_of(found->items().begin(), found->items().end(), is_text))
    return wrong_type(key, *found, "a list of texts in quotes"), otherwise;
  std::vector<std::string> values;
  for (const Value& item : found->items()) values.push_back(item.as_string());
  return values;
}

Reader Reader::section(const std::string& key) {
  static const Value none;
  const Value* found = wanted(key, true);
  return {found != nullptr ? *found : none, file_, *problems_, pointer(key)};
}

std::optional<Reader> Reader::optional_section(const std::string& key) {
  const Value* found = wanted(key, false);
  if (found == nullptr) return std::nullopt;
  return Reader(*found, file_, *problems_, pointer(key));
}

std::vector<Reader> Reader::items(const std::string& key) {
  std::vector<Reader> readers;
  const Value* found = wanted(key, false);
  if (found == nullptr) return readers;
  if (!found->is_array()) return wrong_type(key, *found, "a list of objects, [{...}, ...]"), readers;
  for (std::size_t i = 0; i < found->size(); ++i)
    readers.emplace_back(found->items()[i], file_, *problems_, fmt::format("{}/{}", pointer(key), i));
  return readers;
}

void Reader::done() {
  for (const auto& [key, value] : value_->members()) {
    if (std::find(asked_.begin(), asked_.end(), key) != asked_.end()) continue;
    const std::string near = did_you_mean(key, asked_);
    problems_->add(
        {file_, pointer(key), "", "no such setting.", near.empty() ? "Remove it." : "Did you mean \"" + near + "\"?"});
  }
}

}  // namespace granary::json
