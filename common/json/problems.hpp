// What is wrong with a document, collected so that all of it is said at once.
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/result.hpp"

namespace granary::json {

/// One fault: `wet.json: /dem/time_step is "5 kg": not a time. Allowed: ... Next: ...`
struct Problem {
  std::string file;
  std::string pointer;  ///< JSON pointer of the value; "" is the whole document
  std::string value;    ///< as written; "" if it is missing
  std::string message;  ///< what is wrong and what is allowed, a sentence without the value
  std::string hint;     ///< what to do next; may be empty

  /// "FILE: POINTER is VALUE: MESSAGE HINT", or "FILE: POINTER: MESSAGE HINT" where there is no value.
  std::string text() const;
};

class Problems {
 public:
  void add(Problem problem);  ///< a second problem at the same pointer is dropped: one message a place
  bool empty() const { return problems_.empty(); }
  const std::vector<Problem>& list() const { return problems_; }
  /// All texts, a line each, sorted by pointer. Exit::bad_input.
  Error error() const;

 private:
  std::vector<Problem> problems_;
  std::set<std::pair<std::string, std::string>> places_;  ///< file and pointer of each
};

/// The nearest of `known` if it is near enough to be meant, else "" (edit distance, transpositions count one).
std::string did_you_mean(const std::string& written, const std::vector<std::string>& known);

}  // namespace granary::json
