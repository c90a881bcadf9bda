#include "common/json/io.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <set>

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

/// A key written twice would silently lose its first value: find it while the text is read.
struct DuplicateFinder {
  std::vector<std::set<std::string>> open;
  std::string found;

  bool operator()(int, detail::Library::parse_event_t event, detail::Library& parsed) {
    using Event = detail::Library::parse_event_t;
    if (event == Event::object_start) open.emplace_back();
    if (event == Event::object_end) open.pop_back();
    if (event == Event::key && !open.empty()) {
      const auto& key = parsed.get_ref<const std::string&>();
      if (!open.back().insert(key).second && found.empty()) found = key;
    }
    return true;
  }
};

}  // namespace

Result<Value> parse(std::string_view text, std::string_view name) {
  if (const auto byte = too_deep(text))
    return Error{
        fmt::format("{}: its brackets nest too deep at {}. A bracket may be missing.", name, place(text, *byte))};
  try {
    DuplicateFinder duplicates;
    const auto parsed = detail::Library::parse(text, std::ref(duplicates));
    if (!duplicates.found.empty())
      return Error{
          fmt::format("{}: the key \"{}\" stands twice in one object. Remove one of them.", name, duplicates.found)};
    return detail::from_library(parsed);
  } catch (const detail::Library::parse_error& fault) {
    std::string reason = fault.what();
    if (const auto colon = reason.find("syntax error"); colon != std::string::npos) reason = reason.substr(colon);
    return Error{fmt::format("{}: not valid JSON at {}: {}.", name, place(text, fault.byte), reason)};
  } catch (const detail::Library::exception& fault) {
    return Error{fmt::format("{}: not valid JSON: {}.", name, fault.what())};
  }
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
