// JSON text and files: reading, printing, appending lines, following a growing file of lines.
// The only place (with json/schema) that includes the JSON library.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::json {

/// The value a text holds. `name` (a file's name) opens the message of a syntax error, with line and column.
Result<Value> parse(std::string_view text, std::string_view name);
Result<Value> read_file(const std::filesystem::path& file);

/// One line if indent < 0. Numbers are printed with the digits that read back to the same bits; NaN and infinities as
/// null.
std::string dump(const Value& value, int indent = -1);

/// Writes beside the file and renames over it: a reader sees the old content or the new, never half of it.
Status write_file(const std::filesystem::path& file, const Value& value);

/// Appends one line a value; each line reaches the kernel before append() returns.
class LineWriter {
 public:
  static Result<LineWriter> create(const std::filesystem::path& file);  // truncates
  static Result<LineWriter> append_to(const std::filesystem::path& file);
  LineWriter(LineWriter&& other) noexcept;
  LineWriter& operator=(LineWriter&& other) noexcept;
  ~LineWriter();
  Status append(const Value& value);

 private:
  LineWriter(int fd, std::filesystem::path file) : fd_(fd), file_(std::move(file)) {}
  int fd_ = -1;
  std::filesystem::path file_;
};

/// Follows a growing file of JSON lines: next() gives what has been completed since the last call.
/// A last line without its newline is still being written: it is left for the next call.
class LineReader {
 public:
  explicit LineReader(std::filesystem::path file) : file_(std::move(file)) {}
  /// Empty if nothing new (also while the file does not exist). A whole line that is not JSON is an error naming
  /// file and line number.
  Result<std::vector<Value>> next();
  /// Bytes of an unfinished last line seen by the last next(): 0, or the file was cut there.
  std::size_t torn_bytes() const { return torn_.size(); }

 private:
  std::filesystem::path file_;
  std::uint64_t offset_ = 0;
  std::size_t line_ = 0;
  std::string torn_;
};

/// All lines of a finished file. A torn last line is an error here.
Result<std::vector<Value>> read_lines(const std::filesystem::path& file);

}  // namespace granary::json
