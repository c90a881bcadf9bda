#include "controller/campaign/campaign_schema.hpp"

#include <algorithm>

#include "common/json/io.hpp"
#include "common/json/schema.hpp"
#include "controller/campaign/pointer.hpp"
#include "controller/campaign/workflow_schema_text.hpp"

namespace granary::campaign {

const json::Value& workflow_schema() {
  static const json::Value schema = json::parse(embedded::granary_1, "granary-1.schema.json").value();
  return schema;
}

Status validate_workflow(const json::Value& document, const std::string& file, json::Problems& problems) {
  json::Problems found;
  GRANARY_CHECK(json::validate(document, workflow_schema(), file, found));
  // A fault is also told of every section around it: the innermost place says it best.
  for (const json::Problem& problem : found.list()) {
    const auto is_inside = [&](const json::Problem& other) {
      return other.pointer != problem.pointer && is_within(other.pointer, problem.pointer);
    };
    if (std::none_of(found.list().begin(), found.list().end(), is_inside)) problems.add(problem);
  }
  return {};
}

}  // namespace granary::campaign
