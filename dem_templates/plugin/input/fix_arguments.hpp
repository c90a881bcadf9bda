// The keywords of one of our fix commands, as plain text. Knows no LIGGGHTS type.
#pragma once

#include <string>
#include <vector>

#include "common/json/reader.hpp"
#include "common/result.hpp"

namespace granary::dem {

/// Reads `fix ID GROUP STYLE keyword value ...`, collecting every problem on the way (as json::Reader does).
/// After a problem the functions return the default (or 0, "", {}).
class FixArguments {
 public:
  using Range = json::Range;

  /// words: ID GROUP STYLE, then the keywords. `keywords` names every keyword of the style with its number of values;
  /// kCounted for a length followed by that many values, kEdges for one more than the length.
  static constexpr int kCounted = -1;
  static constexpr int kEdges = -2;
  struct Keyword {
    std::string name;
    int values = 1;
    bool repeats = false;
  };
  FixArguments(const std::vector<std::string>& words, const std::vector<Keyword>& keywords);

  bool has(const std::string& keyword) const;
  std::string text(const std::string& keyword);
  std::string text_or(const std::string& keyword, const std::string& otherwise);
  double number(const std::string& keyword, Range range);
  double number_or(const std::string& keyword, double otherwise, Range range);
  long integer(const std::string& keyword, Range range);
  long integer_or(const std::string& keyword, long otherwise, Range range);
  /// Values of a kEdges keyword: at least two, strictly ascending.
  std::vector<double> edges(const std::string& keyword);
  /// One keyword's values as numbers; each must be in the range.
  std::vector<double> numbers(const std::string& keyword, Range range);
  /// 0, 1, 2 for x, y, z.
  int axis(const std::string& keyword);
  /// The values of each occurrence of a keyword that may repeat.
  std::vector<std::vector<std::string>> all(const std::string& keyword) const;

  void problem(const std::string& message) { problems_.push_back(message); }
  /// Everything that was wrong, a line each; Exit::bad_input.
  Status status() const;

 private:
  struct Given {
    std::string keyword;
    std::vector<std::string> values;
  };
  void read(const std::vector<std::string>& words, const std::vector<Keyword>& keywords);
  void stop_reading(const std::string& message);  ///< what follows cannot be told apart from values
  const Given* find(const std::string& keyword) const;
  const Given* needed(const std::string& keyword);
  double to_number(const std::string& keyword, const std::string& word, Range range, bool whole);

  std::string place_;  ///< "fix tally (granary/tally)"
  std::vector<Given> given_;
  std::vector<std::string> problems_;
  bool readable_ = true;  ///< false: the keywords after the first fault are not known
};

}  // namespace granary::dem
