#include "pilot/journal/line.hpp"

#include <libdeflate.h>

#include <charconv>
#include <cmath>

namespace granary::pilot {
namespace {

// A line is BODY,"sum":"01234567"} where BODY is the object without its closing brace.
constexpr std::string_view kSumOpens = ",\"sum\":\"", kSumCloses = "\"}";
constexpr std::size_t kDigits = 8, kDigitsBefore = 16;
constexpr std::string_view kSequence = "{\"n\":", kWallTime = ",\"wall_s\":", kKind = ",\"kind\":\"",
                           kPayload = "\",\"payload\":";

std::uint64_t sum_of(std::string_view bytes) { return libdeflate_crc32(0, bytes.data(), bytes.size()); }

/// FNV-1a, 64 bits, of lines written before the CRC was: their campaigns go on.
std::uint64_t sum_before(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

struct Parts {
  std::string_view body, sum;
};

/// A line taken apart; nothing if it has no sum.
std::optional<Parts> parts_of(std::string_view line) {
  if (!line.ends_with(kSumCloses)) return std::nullopt;
  line.remove_suffix(kSumCloses.size());
  for (const std::size_t digits : {kDigits, kDigitsBefore}) {
    if (line.size() <= digits) break;
    const std::string_view opened = line.substr(0, line.size() - digits);
    if (opened.ends_with(kSumOpens) && opened.size() > kSumOpens.size())
      return Parts{opened.substr(0, opened.size() - kSumOpens.size()), line.substr(opened.size())};
  }
  return std::nullopt;
}

void append_hex(std::string& text, std::uint64_t number, std::size_t digits) {
  constexpr char kHex[] = "0123456789abcdef";
  while (digits-- > 0) text += kHex[number >> (4 * digits) & 15U];
}

void append_number(std::string& text, std::uint64_t number) {
  char digits[24];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

/// Seconds with six decimals.
void append_time(std::string& text, double seconds) {
  const auto micros = static_cast<std::uint64_t>(std::llround(std::max(0.0, seconds) * 1e6));
  append_number(text, micros / 1'000'000);
  std::string decimals;
  append_number(decimals, micros % 1'000'000 + 1'000'000);
  decimals[0] = '.';
  text += decimals;
}

/// Reads past `opening`; false if it is not there.
bool take(std::string_view& text, std::string_view opening) {
  if (!text.starts_with(opening)) return false;
  text.remove_prefix(opening.size());
  return true;
}

template <class Number>
bool take(std::string_view& text, Number& number) {
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  if (read.ec != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return true;
}

/// What append_time() writes.
bool take_time(std::string_view& text, double& seconds) {
  constexpr std::size_t kDecimals = 6;
  std::uint64_t whole = 0, micros = 0;
  if (!take(text, whole) || !take(text, std::string_view("."))) return false;
  const std::size_t before = text.size();
  if (!take(text, micros) || before - text.size() != kDecimals) return false;
  seconds = static_cast<double>(whole) + 1e-6 * static_cast<double>(micros);
  return true;
}

}  // namespace

void append_line(std::string& text, const Line& line) {
  const std::size_t begin = text.size();
  text += kSequence;
  append_number(text, line.sequence);
  text += kWallTime;
  append_time(text, line.wall_time);
  text += kKind;
  text += line.kind;
  text += kPayload;
  text += line.payload;
  const std::uint64_t sum = sum_of(std::string_view(text).substr(begin));
  text += kSumOpens;
  append_hex(text, sum, kDigits);
  text += kSumCloses;
  text += '\n';
}

bool has_good_sum(std::string_view line) {
  const auto parts = parts_of(line);
  if (!parts) return false;
  const bool before = parts->sum.size() == kDigitsBefore;
  std::string wanted;
  append_hex(wanted, before ? sum_before(parts->body) : sum_of(parts->body), parts->sum.size());
  return parts->sum == wanted;
}

std::optional<Line> read_line(std::string_view line) {
  const auto parts = parts_of(line);
  if (!parts) return std::nullopt;
  std::string_view body = parts->body;
  Line read;
  if (!take(body, kSequence) || !take(body, read.sequence) || !take(body, kWallTime) ||
      !take_time(body, read.wall_time) || !take(body, kKind))
    return std::nullopt;
  const std::size_t end = body.find('"');
  if (end == std::string_view::npos) return std::nullopt;
  read.kind = body.substr(0, end);
  body.remove_prefix(end);
  if (!take(body, kPayload) || body.empty()) return std::nullopt;
  read.payload = body;
  read.text = line;
  return read;
}

}  // namespace granary::pilot
