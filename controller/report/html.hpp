// Small pieces of HTML: escaped text, tables, numbers as people read them. No plots, no knowledge of campaigns.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace granary::report {

/// Text for element content and quoted attributes: & < > " ' become entities; control characters but newline and tab
/// become U+FFFD.
std::string escaped(std::string_view text);

/// Four digits ("0.04123", "2310"), with a power of ten when very small or large ("3.2 × 10⁸"); "–" for NaN.
std::string number(double value);
/// "⁻¹²"
std::string superscript(int exponent);
/// "0.42 s", "38.2 s", "12 min 5 s", "3 h 20 min"; "–" for NaN.
std::string duration(double seconds);
/// "47.3 µm", "1.84 mm"; "–" for NaN and 0: nothing to measure.
std::string diameter(double metres);
/// "87.3 %"; "–" for NaN.
std::string percent(double share);

struct Column {
  enum class Kind { label, number, prose };  ///< a short text; aligned to the right, digits below each other; sentences
  std::string head;
  Kind kind = Kind::label;
};
inline constexpr auto kNumber = Column::Kind::number;
inline constexpr auto kProse = Column::Kind::prose;

/// A table; heads and cells are plain text and are escaped here. Each row has one cell a column.
std::string table(const std::vector<Column>& columns, const std::vector<std::vector<std::string>>& rows);

}  // namespace granary::report
