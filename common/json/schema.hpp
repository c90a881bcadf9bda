// Holds a document against a JSON Schema (draft 7), with problems in our own form.
#pragma once

#include <string>

#include "common/json/problems.hpp"
#include "common/json/value.hpp"

namespace granary::json {

/// Adds a problem for each place of `document` that `schema` refuses. `file` names the document in the messages.
/// An unusable schema is our own mistake: it comes back as an Error with Exit::internal.
Status validate(const Value& document, const Value& schema, const std::string& file, Problems& problems);

}  // namespace granary::json
