// `--set /pointer=value`: settings changed on the command line before the workflow is read.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/json/problems.hpp"
#include "common/json/value.hpp"

namespace granary::campaign {

/// Applies each override in turn. The pointer must name a setting that `schema` knows (it need not be in the document
/// yet); the value is taken as JSON, and as text where it is none: `/machine/impeller_speed=2000 rpm`. Problems are
/// filed under "--set TEXT": no pointer, a setting that does not exist (with a suggestion), a place in a list that is
/// not there.
void apply_overrides(json::Value& document, const std::vector<std::string>& overrides, const json::Value& schema,
                     json::Problems& problems);

/// Why `pointer` names no setting that `schema` knows, as what to do next; nothing if it names one.
std::optional<std::string> unknown_setting(const json::Value& schema, const std::string& pointer);

/// Puts a value at a place, made where the document lacks it. False: the document has no such place in a list, or
/// something single is in the way; it then stays as it was.
bool set_value(json::Value& document, const std::string& pointer, json::Value value);

}  // namespace granary::campaign
