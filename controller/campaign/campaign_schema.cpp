#include "controller/campaign/campaign_schema.hpp"

#include "common/json/io.hpp"
#include "common/json/schema.hpp"
#include "controller/campaign/workflow_schema_text.hpp"

namespace granary::campaign {

const json::Value& workflow_schema() {
  static const json::Value schema = json::parse(embedded::granary_1, "granary-1.schema.json").value();
  return schema;
}

Status validate_workflow(const json::Value& document, const std::string& file, json::Problems& problems) {
  return json::validate(document, workflow_schema(), file, problems);
}

}  // namespace granary::campaign
