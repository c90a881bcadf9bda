#include "controller/report/html.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/assert.hpp"

namespace granary::report {

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        if ((static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f)
          out += "\uFFFD";
        else
          out += c;
    }
  }
  return out;
}

std::string superscript(int exponent) {
  static constexpr std::string_view digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = exponent < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(exponent))) out += digits[c - '0'];
  return out;
}

std::string number(double value) {
  if (std::isnan(value)) return "–";
  const double size = std::abs(value);
  if (value == 0.0 || std::isinf(value) || (size >= 1e-3 && size < 99999.5))
    return fmt::format("{:.{}g}", value, size >= 1e4 ? 5 : 4);
  const std::string text = fmt::format("{:.2e}", value);  // "3.20e+08"
  const auto e = text.find('e');
  return text.substr(0, e) + " × 10" + superscript(std::stoi(text.substr(e + 1)));
}

std::string duration(double seconds) {
  if (std::isnan(seconds)) return "–";
  if (seconds < 120.0) return fmt::format("{:.3g} s", seconds);
  if (!(seconds < 1e9)) return fmt::format("{:.3g} s", seconds);
  const auto whole = static_cast<long>(std::lround(seconds));
  if (whole < 7200) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

std::string diameter(double metres) {
  if (std::isnan(metres) || metres == 0.0) return "–";
  return metres < 1e-3 ? fmt::format("{:.3g} µm", 1e6 * metres) : fmt::format("{:.3g} mm", 1e3 * metres);
}

std::string percent(double share) { return std::isnan(share) ? "–" : fmt::format("{:.1f} %", 100.0 * share); }

std::string table(const std::vector<Column>& columns, const std::vector<std::vector<std::string>>& rows) {
  const auto css_class = [](Column::Kind kind) {
    return kind == Column::Kind::number ? " class=\"n\"" : kind == Column::Kind::prose ? " class=\"t\"" : "";
  };
  std::string out = "<div class=\"scroll\"><table>\n<thead><tr>";
  for (const auto& column : columns) out += fmt::format("<th{}>{}</th>", css_class(column.kind), escaped(column.head));
  out += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    GRANARY_ASSERT(row.size() == columns.size(), row.size());
    out += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i)
      out += fmt::format("<td{}>{}</td>", css_class(columns[i].kind), escaped(row[i]));
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

}  // namespace granary::report
