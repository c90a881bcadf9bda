#include "dem_templates/plugin/input/fix_arguments.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "common/json/problems.hpp"

namespace granary::dem {
namespace {

constexpr const char* kSeeDocs = " See docs/dem_styles.md.";

std::optional<double> parse_number(const std::string& word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

FixArguments::FixArguments(const std::vector<std::string>& words, const std::vector<Keyword>& keywords)
    : place_("fix " + (words.empty() ? std::string("?") : words[0])) {
  if (words.size() > 2) place_ += " (" + words[2] + ")";
  read(words, keywords);
}

void FixArguments::read(const std::vector<std::string>& words, const std::vector<Keyword>& keywords) {
  std::size_t at = 3;  // after ID, group and style
  while (at < words.size()) {
    const std::string& name = words[at++];
    const auto keyword =
        std::find_if(keywords.begin(), keywords.end(), [&](const Keyword& k) { return k.name == name; });
    if (keyword == keywords.end()) {
      std::vector<std::string> names;
      for (const Keyword& known : keywords) names.push_back(known.name);
      const std::string meant = json::did_you_mean(name, names);
      return stop_reading("'" + name + "' is no keyword of it" +
                          (meant.empty() ? "." : "; did you mean '" + meant + "'?"));
    }
    long n = keyword->values;
    if (n < 0) {
      const auto length = at < words.size() ? parse_number(words[at]) : std::nullopt;
      if (!length || *length < 1.0 || *length != std::floor(*length) || *length > 1e6)
        return stop_reading("'" + name + "' needs its length, a whole number of at least 1.");
      n = static_cast<long>(*length) + (keyword->values == kEdges ? 1 : 0);
      ++at;
    }
    if (at + static_cast<std::size_t>(n) > words.size())
      return stop_reading("'" + name + "' needs " + std::to_string(n) + " value(s), " +
                          std::to_string(words.size() - at) + " are given.");
    if (!keyword->repeats && has(name)) problem("'" + name + "' is given twice.");
    const auto begin = words.begin() + static_cast<std::ptrdiff_t>(at);
    given_.push_back({name, {begin, begin + n}});
    at += static_cast<std::size_t>(n);
  }
}

void FixArguments::stop_reading(const std::string& message) {
  problem(message);
  readable_ = false;
}

bool FixArguments::has(const std::string& keyword) const { return find(keyword) != nullptr; }

std::string FixArguments::text(const std::string& keyword) {
  const Given* given = needed(keyword);
  return given ? given->values[0] : "";
}

std::string FixArguments::text_or(const std::string& keyword, const std::string& otherwise) {
  return has(keyword) ? text(keyword) : otherwise;
}

double FixArguments::number(const std::string& keyword, Range range) {
  const Given* given = needed(keyword);
  return given ? to_number(keyword, given->values[0], range, false) : 0.0;
}

double FixArguments::number_or(const std::string& keyword, double otherwise, Range range) {
  return has(keyword) ? number(keyword, range) : otherwise;
}

long FixArguments::integer(const std::string& keyword, Range range) {
  const Given* given = needed(keyword);
  return given ? static_cast<long>(to_number(keyword, given->values[0], range, true)) : 0;
}

long FixArguments::integer_or(const std::string& keyword, long otherwise, Range range) {
  return has(keyword) ? integer(keyword, range) : otherwise;
}

std::vector<double> FixArguments::edges(const std::string& keyword) {
  const std::vector<double> values = numbers(keyword, Range::any());
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] <= values[i - 1]) {
      problem("the edges of '" + keyword + "' must ascend: edge " + std::to_string(i) + " does not.");
      break;
    }
  }
  return values;
}

std::vector<double> FixArguments::numbers(const std::string& keyword, Range range) {
  std::vector<double> values;
  if (const Given* given = needed(keyword))
    for (const std::string& word : given->values) values.push_back(to_number(keyword, word, range, false));
  return values;
}

int FixArguments::axis(const std::string& keyword) {
  const Given* given = needed(keyword);
  if (!given) return 0;
  const std::string& word = given->values[0];
  if (word == "x" || word == "y" || word == "z") return word[0] - 'x';
  problem("'" + keyword + "' is '" + word + "'; it must be x, y or z.");
  return 0;
}

std::vector<std::vector<std::string>> FixArguments::all(const std::string& keyword) const {
  std::vector<std::vector<std::string>> found;
  for (const Given& given : given_)
    if (given.keyword == keyword) found.push_back(given.values);
  return found;
}

Status FixArguments::status() const {
  if (problems_.empty()) return {};
  std::string message;
  for (const std::string& text : problems_) message += (message.empty() ? "" : "\n") + place_ + ": " + text + kSeeDocs;
  return Error{message, Exit::bad_input};
}

const FixArguments::Given* FixArguments::find(const std::string& keyword) const {
  for (const Given& given : given_)
    if (given.keyword == keyword) return &given;
  return nullptr;
}

const FixArguments::Given* FixArguments::needed(const std::string& keyword) {
  const Given* given = find(keyword);
  if (!given && readable_) problem("needs the keyword '" + keyword + "'.");
  return given;
}

double FixArguments::to_number(const std::string& keyword, const std::string& word, Range range, bool whole) {
  const auto value = parse_number(word);
  if (!value || (whole && *value != std::floor(*value)) || !range.contains(*value)) {
    problem("'" + keyword + "' is '" + word + "'; it must be a" + (whole ? " whole" : "") + " number " + range.text() +
            ".");
    return 0.0;
  }
  return *value;
}

}  // namespace granary::dem
