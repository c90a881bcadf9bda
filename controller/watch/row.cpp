#include "controller/watch/row.hpp"

namespace granary::watch {

namespace {

// Colours of the 256 that are readable on black and on white.
std::string_view sgr(Ink ink) {
  switch (ink) {
    case Ink::plain:
      return "";
    case Ink::soft:
      return "\033[38;5;245m";
    case Ink::bold:
      return "\033[1m";
    case Ink::dem:
      return "\033[38;5;32m";
    case Ink::pbm:
      return "\033[38;5;166m";
    case Ink::estimation:
      return "\033[38;5;35m";
    case Ink::monitor:
      return "\033[38;5;103m";
    case Ink::good:
      return "\033[38;5;35m";
    case Ink::bad:
      return "\033[1;38;5;160m";
  }
  return "";
}

bool begins_code_point(char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }

}  // namespace

Ink ink_of_kind(std::string_view kind) {
  if (kind == "dem") return Ink::dem;
  if (kind == "pbm") return Ink::pbm;
  if (kind == "estimation") return Ink::estimation;
  return kind == "monitor" ? Ink::monitor : Ink::plain;
}

int width_of(std::string_view text) {
  int width = 0;
  for (const char c : text) width += begins_code_point(c);
  return width;
}

int width_of(const Row& row) {
  int width = 0;
  for (const Span& span : row) width += width_of(span.text);
  return width;
}

std::string clipped(std::string_view text, int columns) {
  std::string out;
  int width = 0;
  for (const char c : text) {
    if (begins_code_point(c) && ++width > columns) break;
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x20 || byte == 0x7f ? '?' : c;
  }
  return out;
}

std::string printed(const Row& row, int columns, bool colour) {
  std::string out;
  for (const Span& span : row) {
    const std::string text = clipped(span.text, columns);
    columns -= width_of(text);
    const std::string_view on = colour ? sgr(span.ink) : "";
    if (!text.empty()) out += std::string(on) + text + (on.empty() ? "" : "\033[0m");
  }
  return out;
}

}  // namespace granary::watch
