#include "dem_templates/plugin/tally/told_lines.hpp"

#include <filesystem>
#include <string_view>

#include "common/files.hpp"

namespace granary::dem {

Status forget_lines_after(const std::string& file, double time) {
  if (!std::filesystem::exists(file)) return {};
  GRANARY_TRY(const std::string text, read_text(file));
  const double latest = time * (1.0 + 1e-9);  // the clock is a sum of steps
  std::string kept;
  for (std::size_t at = 0, end = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    const std::string_view line = std::string_view(text).substr(at, end - at);
    GRANARY_TRY(const json::Value value, json::parse(line, file));
    if (value.number_or("time_s", 0.0) > latest) continue;
    kept.append(line).push_back('\n');
  }
  return kept == text ? Status{} : write_text_atomically(file, kept);
}

Result<json::LineWriter> go_on_telling(const std::string& file, double time) {
  GRANARY_CHECK(forget_lines_after(file, time));
  return json::LineWriter::append_to(file);
}

}  // namespace granary::dem
