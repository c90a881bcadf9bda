// The published JSON Schema of workflows (workflows/schema/granary-1.schema.json), carried in the program.
#pragma once

#include "common/json/problems.hpp"
#include "common/json/value.hpp"
#include "common/result.hpp"

namespace granary::campaign {

const json::Value& workflow_schema();

/// Holds a workflow against the schema. Errors: the schema cannot be used (our own mistake).
Status validate_workflow(const json::Value& document, const std::string& file, json::Problems& problems);

}  // namespace granary::campaign
