// The reader, the published schema and the documentation know the same settings and the same defaults.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/campaign/campaign_schema.hpp"
#include "controller/campaign/pointer.hpp"

namespace granary::campaign {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = GRANARY_SOURCE_DIR;

/// Calls `visit` with the pointer and the schema of every setting; "*" stands for the items of a list of sections.
void walk(const json::Value& node, const std::string& at,
          const std::function<void(const std::string&, const json::Value&)>& visit) {
  if (!at.empty()) visit(at, node);
  if (const json::Value* properties = node.find("properties"))
    for (const auto& [key, child] : properties->members()) walk(child, at + "/" + key, visit);
  if (node["items"].find("properties") != nullptr)
    for (const auto& [key, child] : node["items"]["properties"].members()) walk(child, at + "/*/" + key, visit);
}

void walk_schema(const std::function<void(const std::string&, const json::Value&)>& visit) {
  walk(workflow_schema(), "", visit);
}

/// The pointers of all members of a document, with "*" for the items of lists.
void collect(const json::Value& value, const std::string& at, std::set<std::string>& pointers) {
  pointers.insert(at);
  if (value.is_object())
    for (const auto& [key, child] : value.members()) collect(child, at + "/" + key, pointers);
  if (value.is_array())
    for (const json::Value& item : value.items()) collect(item, at + "/*", pointers);
}

std::vector<fs::path> complete_workflows() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kSource / "tests/data/workflows_complete"))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  return files;
}

TEST(WorkflowSchema, AgreesWithTheReaderOnWorkflowsThatUseEverySetting) {
  for (const fs::path& file : complete_workflows()) {
    const auto campaign = read_campaign(file);
    EXPECT_TRUE(campaign.has_value()) << (campaign ? "" : campaign.error().message);
  }
}

TEST(WorkflowSchema, KnowsNoSettingThatTheCompleteWorkflowsLack) {
  std::set<std::string> used;
  for (const fs::path& file : complete_workflows()) collect(json::read_file(file).value(), "", used);

  walk_schema([&](const std::string& pointer, const json::Value&) { EXPECT_EQ(used.count(pointer), 1u) << pointer; });
}

TEST(WorkflowSchema, KnowsEverySettingThatTheReaderAsksFor) {
  std::set<std::string> known;
  walk_schema(
      [&](const std::string& pointer, const json::Value&) { known.insert(pointer.substr(pointer.rfind('/') + 1)); });

  const std::regex asked(
      R"re(\b(?:number|number_or|integer|integer_or|boolean_or|text|text_or|choice|choice_or|quantity|quantity_or|)re"
      R"re(quantities|numbers|texts_or|section|optional_section|items|raw|small_integer|seconds|is_auto)\("(\w+)")re"
      R"re(|(?:section_or_empty|read_length|read_count|read_mesh|\w+_pair_or)\(\w+, "(\w+)")re");
  int n = 0;
  std::vector<fs::path> sources{kSource / "pilot/task/spec_json.cpp"};
  for (const auto& entry : fs::directory_iterator(kSource / "controller/campaign"))
    if (entry.path().extension() == ".cpp" && entry.path().filename() != "written.cpp") sources.push_back(entry.path());
  for (const fs::path& source : sources) {
    std::string text = read_text(source).value();
    if (source.filename() == "spec_json.cpp") text = text.substr(0, text.find("TaskSpec spec_from_json"));
    for (std::sregex_iterator it(text.begin(), text.end(), asked), end; it != end; ++it) {
      const std::string key = (*it)[1].matched ? (*it)[1] : (*it)[2];
      if (key.size() == 1) continue;  // "0", "1": items of a list
      ++n;
      EXPECT_EQ(known.count(key), 1u) << key << " in " << source.filename();
    }
  }
  EXPECT_GT(n, 100);
}

/// A campaign.json's "understood" part, a line each value.
std::vector<std::string> understood(const json::Value& document) {
  const fs::path file = fs::path(testing::TempDir()) / "campaign_schema_test.json";
  EXPECT_TRUE(json::write_file(file, document).has_value());
  const auto campaign = read_campaign(file);
  EXPECT_TRUE(campaign.has_value()) << (campaign ? "" : campaign.error().message);
  std::istringstream text(campaign ? json::dump(to_json(*campaign)["understood"], 1) : "");
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

/// Writes the schema's defaults into a document, in every section that is there or may be left out; `skipped` opens the
/// titles of the settings of the other machine. Returns how many.
int fill_defaults(const json::Value& schema, json::Value& value, const std::string& skipped) {
  const std::set<std::string> optional{
      "feed", "charge", "spray", "estimation", "sweep", "agglomerates", "coarse_graining_law"};  // only where asked for
  int n = 0;
  if (value.is_array())
    for (json::Value& item : value.items()) n += fill_defaults(schema["items"], item, skipped);
  if (!value.is_object() || schema.find("properties") == nullptr) return n;
  for (const auto& [key, setting] : schema["properties"].members()) {
    if (setting.text_or("title", "").rfind(skipped, 0) == 0 || (optional.count(key) == 1 && value.find(key) == nullptr))
      continue;
    if (value.find(key) == nullptr && setting.find("properties") != nullptr) value.set(key, json::Value::object());
    if (value.find(key) != nullptr) {
      n += fill_defaults(setting, *value.find(key), skipped);
    } else if (const json::Value* standard = setting.find("default"); standard != nullptr) {
      value.set(key, *standard);
      ++n;
    }
  }
  return n;
}

/// Lines of the one that are not in the other, at the same place.
std::vector<std::string> differences(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  std::vector<std::string> found;
  if (a.size() != b.size()) found.push_back("another number of lines");
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (a[i] != b[i]) found.push_back(a[i] + " / " + b[i]);
  return found;
}

void expect_the_same_with_defaults_written_out(const char* text, const std::string& skipped, int least) {
  const json::Value bare = json::parse(text, "test").value();
  json::Value filled = bare;
  const json::Value& schema = workflow_schema();
  const bool tasks = bare.find("tasks") != nullptr;

  const int n = tasks ? fill_defaults(schema["properties"]["tasks"], *filled.find("tasks"), skipped)
                      : fill_defaults(schema, filled, skipped);

  EXPECT_GE(n, least);
  EXPECT_THAT(differences(understood(filled), understood(bare)), testing::IsEmpty());
}

TEST(WorkflowSchema, HasTheDefaultsOfTheReader) {
  expect_the_same_with_defaults_written_out(R"({"granary": 1, "kind": "coupled", "name": "a",
      "materials": {"solids": [{}, {}]}, "machine": {"type": "cm5", "impeller_speed": "2000 rpm"},
      "feed": {"rate": "15 kg/h"}, "process": {"duration": "60 s", "residence_time": "5 s"},
      "spray": {"liquid_to_solid": 0.3},
      "pbm": {"aggregation": {}, "breakage": {}, "consolidation": {"rate": "1 1/s"}}})",
                                            "batch_bowl:", 70);
  expect_the_same_with_defaults_written_out(R"({"granary": 1, "kind": "coupled", "name": "a",
      "machine": {"type": "batch_bowl", "impeller_speed": "300 rpm"}, "charge": {"mass": "20 g"},
      "process": {"duration": "60 s"}, "spray": {"rate": "1 ml/s"},
      "pbm": {"aggregation": {}, "breakage": {}, "consolidation": {"rate": "1 1/s"}}})",
                                            "cm5:", 70);
  expect_the_same_with_defaults_written_out(R"({"granary": 1, "kind": "tasks", "name": "a",
      "tasks": [{"name": "b", "command": ["true"]}]})",
                                            "none", 12);
}

TEST(WorkflowSchema, RefusesByItselfWhatAnEditorShouldMark) {
  for (const char* name : {"misspelt_key", "bare_number", "quantity_without_unit", "missing_section", "missing_key",
                           "out_of_range", "wrong_choice", "wrong_type", "zero_particles", "wrong_version",
                           "wrong_pair", "task_command_text", "tasks_missing", "bad_name"}) {
    const fs::path file = kSource / "tests/data/workflows_broken" / (std::string(name) + ".json");
    json::Problems problems;
    ASSERT_TRUE(validate_workflow(json::read_file(file).value(), name, problems).has_value());
    EXPECT_FALSE(problems.empty()) << name;
  }
}

TEST(WorkflowFormatDocument, HasEverySettingWithItsDefault) {
  std::map<std::string, std::string> rows;  // pointer -> its line
  std::istringstream lines(read_text(kSource / "docs/workflow_format.md").value());
  const std::regex row(R"(^\| `(/[^`]*)` \|)");
  std::smatch found;
  for (std::string line; std::getline(lines, line);)
    if (std::regex_search(line, found, row)) rows[found[1]] = line;

  std::set<std::string> known;
  walk_schema([&](const std::string& pointer, const json::Value& setting) {
    known.insert(pointer);
    ASSERT_EQ(rows.count(pointer), 1u) << pointer;
    if (const json::Value* standard = setting.find("default"); standard != nullptr) {
      EXPECT_THAT(rows[pointer], testing::HasSubstr("`" + json::dump(*standard) + "`"));
    }
    if (const json::Value* choices = setting.find("enum"); choices != nullptr) {
      for (const json::Value& choice : choices->items())
        EXPECT_THAT(rows[pointer], testing::HasSubstr(choice.is_string() ? choice.as_string() : json::dump(choice)));
    }
  });
  for (const auto& [pointer, line] : rows)
    EXPECT_EQ(known.count(pointer), 1u) << pointer << " is documented but no setting";
}

}  // namespace
}  // namespace granary::campaign
