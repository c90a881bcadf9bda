// Reads the members of a JSON object into plain values, collecting every problem on the way.
// A member nobody asked for is a problem too, with a suggestion: call done() when all have been asked for.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/json/problems.hpp"
#include "common/json/value.hpp"

namespace granary::json {

/// The numbers a setting may have. Prints itself for messages: "> 0", "in (0, 1]", ">= 1".
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_included = true;
  bool high_included = true;

  bool contains(double x) const;  ///< NaN is in no range
  std::string text() const;
  std::string clause() const;  ///< ", > 0" to end a sentence with; nothing if any number will do

  static Range any() { return {}; }
  static Range positive() { return {0.0, std::numeric_limits<double>::infinity(), false, true}; }
  static Range not_negative() { return {0.0, std::numeric_limits<double>::infinity(), true, true}; }
  static Range at_least(double low) { return {low, std::numeric_limits<double>::infinity(), true, true}; }
  static Range between(double low, double high) { return {low, high, true, true}; }
  static Range fraction() { return {0.0, 1.0, true, true}; }
};

/// After a problem the functions return the default (or 0, "", {}), so that reading goes on to find the next one.
class Reader {
 public:
  /// `value` and `problems` must outlive the reader. A value that is no object is a problem.
  Reader(const Value& value, std::string file, Problems& problems, std::string pointer = "");

  bool has(const std::string& key);

  double number(const std::string& key, Range range = Range::any());
  double number_or(const std::string& key, double otherwise, Range range = Range::any());
  std::int64_t integer(const std::string& key, Range range = Range::any());
  std::int64_t integer_or(const std::string& key, std::int64_t otherwise, Range range = Range::any());
  bool boolean_or(const std::string& key, bool otherwise);
  std::string text(const std::string& key);
  std::string text_or(const std::string& key, std::string otherwise);
  std::string choice(const std::string& key, const std::vector<std::string>& allowed);
  std::string choice_or(const std::string& key, std::string otherwise, const std::vector<std::string>& allowed);

  /// A string with a unit ("2000 rpm", "15 kg/h") converted to `si_unit` ("rad/s", "kg/s"); the range is in SI.
  /// A bare number is a problem: it has no unit. Dimensionless settings are number()s.
  double quantity(const std::string& key, const std::string& si_unit, Range range = Range::any());
  double quantity_or(const std::string& key, double otherwise_si, const std::string& si_unit,
                     Range range = Range::any());
  std::vector<double> quantities(const std::string& key, const std::string& si_unit, Range range = Range::any());

  std::vector<double> numbers(const std::string& key, Range range = Range::any());
  std::vector<std::string> texts_or(const std::string& key, std::vector<std::string> otherwise);

  /// A member that is an object. Missing: section() is a problem (and reads as empty), the other gives nothing.
  Reader section(const std::string& key);
  std::optional<Reader> optional_section(const std::string& key);
  /// A reader for each object of an array member; a missing array is empty.
  std::vector<Reader> items(const std::string& key);

  /// Marks a member as known without reading it here.
  const Value* raw(const std::string& key);

  /// Says that `key` is wrong, in the caller's words.
  void problem(const std::string& key, std::string message, std::string hint = "");
  /// Every member that was never asked for is a problem: unknown key, with a suggestion.
  void done();

  std::string pointer(const std::string& key) const;
  const std::string& file() const { return file_; }

 private:
  const Value* wanted(const std::string& key, bool required);
  void wrong_type(const std::string& key, const Value& value, const std::string& wanted);

  const Value* value_;
  std::string file_;
  Problems* problems_;
  std::string pointer_;
  std::vector<std::string> asked_;
};

}  // namespace granary::json
