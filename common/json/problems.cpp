#include "common/json/problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace granary::json {

std::string Problem::text() const {
  std::string line = file + ": ";
  if (!pointer.empty()) line += pointer;
  if (!value.empty()) line += (pointer.empty() ? "the document is " : " is ") + value;
  if (!pointer.empty() || !value.empty()) line += ": ";
  line += message;
  if (!hint.empty()) line += " " + hint;
  return line;
}

void Problems::add(Problem problem) {
  if (places_.emplace(problem.file, problem.pointer).second) problems_.push_back(std::move(problem));
}

Error Problems::error() const {
  auto sorted = problems_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Problem& a, const Problem& b) {
    return std::tie(a.file, a.pointer) < std::tie(b.file, b.pointer);
  });
  std::string text;
  for (const Problem& problem : sorted) text += (text.empty() ? "" : "\n") + problem.text();
  return {text, Exit::bad_input};
}

namespace {

/// Optimal string alignment distance: insertions, deletions, substitutions and swaps of neighbours.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string did_you_mean(const std::string& written, const std::vector<std::string>& known) {
  std::string best;
  std::size_t least = std::max<std::size_t>(2, written.size() / 3) + 1;
  for (const std::string& word : known) {
    // As many letters as one is longer must be put in: do not count the others of a word that long.
    if (written.size() >= least + word.size()) continue;
    if (const std::size_t d = distance(written, word); d < least && d < word.size()) {
      least = d;
      best = word;
    }
  }
  return best;
}

}  // namespace granary::json
