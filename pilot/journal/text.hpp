// JSON text of journal payloads, written and read back without detours: a journal has millions of short lines, all of
// our own making. Files of users go through common/json/io, which says where they are wrong.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/json/value.hpp"

namespace granary::pilot {

/// Appends the value on one line. Numbers read back to the same bits; NaN and infinities become null.
void append_json(std::string& text, const json::Value& value);
void append_json(std::string& text, std::string_view value);
void append_json(std::string& text, double value);

/// The value of a text that append_json() (or any JSON writer) wrote; nothing if it is not JSON.
std::optional<json::Value> parse_json(std::string_view text);

}  // namespace granary::pilot
