// `--set /pointer=value`: settings changed on the command line before the workflow is read.
#pragma once

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

}  // namespace granary::campaign
