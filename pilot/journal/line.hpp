// One line of a journal: its members, its checksum. docs/journal_format.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace granary::pilot {

/// The members of a line as they stand in it; they live as long as the line's text.
struct Line {
  std::uint64_t sequence = 0;
  double wall_time = 0.0;
  std::string_view kind;
  std::string_view payload;  ///< JSON
  std::string_view text;     ///< of a line that was read: all of it, without its newline
};

/// Appends the line, by its members, with its checksum and newline.
void append_line(std::string& text, const Line& line);
/// Whether the line (without its newline) ends with the right checksum of what is before it.
bool has_good_sum(std::string_view line);
/// The members of a line of good checksum; nothing if it does not have the form append_line() gives it.
std::optional<Line> read_line(std::string_view line);

}  // namespace granary::pilot
