// Fills templates: text with placeholders like @{time_step}.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/result.hpp"

namespace granary::dem {

/// A placeholder's name and the text that takes its place.
using Values = std::vector<std::pair<std::string, std::string>>;

/// The template with every placeholder replaced by its value; values are put in as they are.
/// Errors: a placeholder without a value, a value without a placeholder, a name given twice, a placeholder without its
/// closing brace; each names the template, the placeholder and, where it is in the text, its line.
Result<std::string> render(std::string_view text, std::string_view template_name, const Values& values);

/// A number with the digits that read back to the same bits.
std::string digits(double number);

}  // namespace granary::dem
