#include "common/json/schema.hpp"

#include <fmt/format.h>

#include <exception>
// valijson's default is to throw through its own macro; exceptions are caught here and go no further.
#define VALIJSON_USE_EXCEPTIONS 1
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "common/json/io.hpp"
#include "common/json/nlohmann.hpp"

namespace granary::json {
namespace {

nlohmann::json plain(const Value& value) { return nlohmann::json::parse(dump(value)); }

/// valijson's context is ["<root>", "[dem]", "[2]"]: as a JSON pointer.
std::string pointer_of(const std::vector<std::string>& context) {
  std::string pointer;
  for (const std::string& step : context)
    if (step.size() > 2 && step.front() == '[') pointer += "/" + step.substr(1, step.size() - 2);
  return pointer;
}

std::string shown(const nlohmann::json& document, const std::string& pointer) {
  try {
    std::string text = document.at(nlohmann::json::json_pointer(pointer)).dump();
    return text.size() > 60 ? text.substr(0, 57) + "..." : text;
  } catch (const nlohmann::json::exception&) {
    return "";
  }
}

}  // namespace

Status validate(const Value& document, const Value& schema, const std::string& file, Problems& problems) {
  const nlohmann::json schema_document = plain(schema);
  const nlohmann::json target = plain(document);
  try {
    valijson::Schema parsed;
    valijson::SchemaParser parser;
    parser.populateSchema(valijson::adapters::NlohmannJsonAdapter(schema_document), parsed);
    valijson::Validator validator;
    valijson::ValidationResults results;
    validator.validate(parsed, valijson::adapters::NlohmannJsonAdapter(target), &results);
    for (valijson::ValidationResults::Error error; results.popError(error);) {
      const std::string pointer = pointer_of(error.context);
      problems.add({file, pointer, pointer.empty() ? "" : shown(target, pointer), error.description, ""});
    }
  } catch (const std::exception& fault) {
    return Error{fmt::format("the schema for {} cannot be used: {}", file, fault.what()), Exit::internal};
  }
  return {};
}

}  // namespace granary::json
