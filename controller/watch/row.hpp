// A row of text for a terminal: pieces in inks, clipped and coloured only when it is printed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace granary::watch {

enum class Ink { plain, soft, bold, dem, pbm, estimation, monitor, good, bad };
Ink ink_of_kind(std::string_view kind);  ///< of a task

struct Span {
  std::string text;
  Ink ink = Ink::plain;
};
using Row = std::vector<Span>;

/// Columns a text takes: its code points (ours are all one column wide).
int width_of(std::string_view text);
int width_of(const Row& row);
/// At most so many columns of it; control characters, which could be orders to the terminal, become '?'.
std::string clipped(std::string_view text, int columns);
/// The row as it is printed, without a newline; ANSI colours (SGR) only if `colour`.
std::string printed(const Row& row, int columns, bool colour);

}  // namespace granary::watch
