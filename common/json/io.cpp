#include "common/json/io.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <vector>

#include "common/files.hpp"
#include "common/json/nlohmann.hpp"

namespace granary::json {
namespace fs = std::filesystem;
namespace {

/// "line 3, column 7" of a byte.
std::string place(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte > 0 ? byte - 1 : 0, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const auto newline = before.rfind('\n');
  const auto column = newline == std::string_view::npos ? before.size() + 1 : before.size() - newline;
  return fmt::format("line {}, column {}", line, column);
}

/// The byte at which brackets nest deeper than any file of ours does; each level costs stack in all that walks a value.
std::optional<std::size_t> too_deep(std::string_view text) {
  constexpr int kDeepest = 200;
  int depth = 0;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (quoted && c == '\\') ++at;  // whatever is escaped ends no string
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (depth > kDeepest) return at + 1;
  }
  return std::nullopt;
}

/// The key that stands twice among these, if one does: it would silently lose its first value.
const std::string* twice_in(const std::vector<Member>& members) {
  constexpr std::size_t kFew = 24;  // up to so many, comparing all pairs is cheaper than sorting
  if (members.size() <= kFew) {
    for (std::size_t a = 1; a < members.size(); ++a)
      for (std::size_t b = 0; b < a; ++b)
        if (members[a].first == members[b].first) return &members[a].first;
    return nullptr;
  }
  std::vector<const std::string*> keys;
  for (const Member& member : members) keys.push_back(&member.first);
  std::sort(keys.begin(), keys.end(), [](const auto* a, const auto* b) { return *a < *b; });
  const auto same = std::adjacent_find(keys.begin(), keys.end(), [](const auto* a, const auto* b) { return *a == *b; });
  return same == keys.end() ? nullptr : *same;
}

/// Makes our values from what the library reads, as it reads it: in time proportional to the text.
class Builder : public nlohmann::json_sax<detail::Library> {
 public:
  bool null() override { return add({}); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override {
    if (value > INT64_MAX) return add(static_cast<double>(value));  // beyond int64 only a double can hold it
    return add(static_cast<std::int64_t>(value));
  }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t&) override { return false; }  // not in text
  bool start_object(std::size_t) override { return open(Value::object()); }
  bool start_array(std::size_t) override { return open(Value::array()); }
  bool key(string_t& name) override {
    key_ = std::move(name);
    return true;
  }
  bool end_object() override {
    if (const std::string* key = twice_in(open_.back()->members()); key != nullptr && duplicate_.empty())
      duplicate_ = *key;
    return end_array();
  }
  bool end_array() override {
    open_.pop_back();
    return true;
  }
  bool parse_error(std::size_t byte, const std::string&, const detail::Library::exception& fault) override {
    is_syntax_ = dynamic_cast<const detail::Library::parse_error*>(&fault) != nullptr;
    byte_ = byte;
    fault_ = fault.what();
    return false;
  }

  Value take() { return std::move(root_); }
  const std::string& duplicate() const { return duplicate_; }  ///< a key that stands twice; empty: none
  const std::string& fault() const { return fault_; }          ///< what the library says
  bool is_syntax() const { return is_syntax_; }                ///< the fault is one of syntax, and has a place
  std::size_t byte() const { return byte_; }

 private:
  /// While a list or object is open nothing is added beside it, so a pointer to it stays good.
  Value& place(Value value) {
    if (open_.empty()) return root_ = std::move(value);
    Value& into = *open_.back();
    if (into.is_array()) return into.items().emplace_back(std::move(value));
    return into.members().emplace_back(std::move(key_), std::move(value)).second;
  }
  bool add(Value value) {
    place(std::move(value));
    return true;
  }
  bool open(Value value) {
    open_.push_back(&place(std::move(value)));
    return true;
  }

  Value root_;
  std::vector<Value*> open_;
  std::string key_, duplicate_, fault_;
  std::size_t byte_ = 0;
  bool is_syntax_ = false;
};

}  // namespace

Result<Value> parse(std::string_view text, std::string_view name) {
  if (const auto byte = too_deep(text))
    return Error{
        fmt::format("{}: its brackets nest too deep at {}. A bracket may be missing.", name, place(text, *byte))};
  Builder builder;
  if (!detail::Library::sax_parse(text, &builder)) {
    if (!builder.is_syntax()) return Error{fmt::format("{}: not valid JSON: {}.", name, builder.fault())};
    std::string reason = builder.fault();
    if (const auto colon = reason.find("syntax error"); colon != std::string::npos) reason = reason.substr(colon);
    return Error{fmt::format("{}: not valid JSON at {}: {}.", name, place(text, builder.byte()), reason)};
  }
  if (!builder.duplicate().empty())
    return Error{
        fmt::format("{}: the key \"{}\" stands twice in one object. Remove one of them.", name, builder.duplicate())};
  return builder.take();
}

Result<Value> read_file(const fs::path& file) {
  GRANARY_TRY(const std::string text, read_text(file));
  return parse(text, file.string());
}

std::string dump(const Value& value, int indent) {
  return detail::to_library(value).dump(indent, ' ', false, detail::Library::error_handler_t::replace);
}

Status write_file(const fs::path& file, const Value& value) {
  return write_text_atomically(file, dump(value, 1) + "\n");
}

// ---- LineWriter

namespace {
Result<int> open_lines(const fs::path& file, int how) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | how, 0644);
  if (fd < 0)
    return Error{fmt::format("{}: cannot be written: {}.", file.string(), std::strerror(errno)), Exit::task_failed};
  return fd;
}
}  // namespace

Result<LineWriter> LineWriter::create(const fs::path& file) {
  GRANARY_TRY(const int fd, open_lines(file, O_TRUNC));
  return LineWriter(fd, file);
}

Result<LineWriter> LineWriter::append_to(const fs::path& file) {
  GRANARY_TRY(const int fd, open_lines(file, 0));
  return LineWriter(fd, file);
}

LineWriter::LineWriter(LineWriter&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), file_(std::move(other.file_)) {}

LineWriter& LineWriter::operator=(LineWriter&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(file_, other.file_);
  return *this;
}

LineWriter::~LineWriter() {
  if (fd_ >= 0) ::close(fd_);
}

Status LineWriter::append(const Value& value) {
  const std::string line = dump(value) + "\n";
  std::string_view rest = line;
  while (!rest.empty()) {
    const ssize_t n = ::write(fd_, rest.data(), rest.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const char* advice = errno == ENOSPC || errno == EDQUOT ? " Free some space, then resume." : "";
      return Error{fmt::format("{}: cannot be written: {}.{}", file_.string(), std::strerror(errno), advice),
                   Exit::task_failed};
    }
    rest.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

// ---- LineReader

Result<std::vector<Value>> LineReader::next() {
  std::vector<Value> values;
  std::ifstream in(file_, std::ios::binary);
  if (!in) return values;
  in.seekg(static_cast<std::streamoff>(offset_));
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::size_t start = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', start)) {
    const std::string_view line = std::string_view(text).substr(start, end - start);
    ++line_;
    if (line.find_first_not_of(" \t\r") != std::string_view::npos) {
      auto value = parse(line, fmt::format("{}, line {}", file_.string(), line_));
      if (!value) return std::move(value).error();
      values.push_back(*std::move(value));
    }
    start = end + 1;
    offset_ += line.size() + 1;
  }
  torn_ = text.substr(start);
  return values;
}

Result<std::vector<Value>> read_lines(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return Error{file.string() + ": there is no such file."};
  LineReader reader(file);
  GRANARY_TRY(auto values, reader.next());
  if (reader.torn_bytes() > 0)
    return Error{
        fmt::format("{}: its last line, number {}, is cut short after {} bytes. The program that wrote it was killed, "
                    "or the disk is full.",
                    file.string(), values.size() + 1, reader.torn_bytes())};
  return values;
}

}  // namespace granary::json
