// --set /pointer=value.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/campaign/campaign_schema.hpp"
#include "controller/campaign/overrides.hpp"

namespace granary::campaign {
namespace {

json::Value document(const char* text) { return json::parse(text, "test").value(); }

/// The document after the overrides, as text; or what was wrong with them.
std::string after(const char* text, const std::vector<std::string>& overrides) {
  json::Value changed = document(text);
  json::Problems problems;
  apply_overrides(changed, overrides, workflow_schema(), problems);
  return problems.empty() ? json::dump(changed) : problems.error().message;
}

TEST(Overrides, ReplaceOrAddASetting) {
  EXPECT_EQ(after(R"({"pbm": {"bins": 16}})", {"/pbm/bins=32"}), R"({"pbm":{"bins":32}})");
  EXPECT_EQ(after("{}", {"/dem/guard/largest_overlap=0.1"}), R"({"dem":{"guard":{"largest_overlap":0.1}}})");
}

TEST(Overrides, TakeTheValueAsJsonElseAsText) {
  EXPECT_EQ(after("{}", {"/pbm/bins=[16, 24]"}), R"({"pbm":{"bins":[16,24]}})");
  EXPECT_EQ(after("{}", {"/machine/impeller_speed=1500 rpm"}), R"({"machine":{"impeller_speed":"1500 rpm"}})");
  EXPECT_EQ(after("{}", {"/machine/impeller_speed=\"1500 rpm\""}), R"({"machine":{"impeller_speed":"1500 rpm"}})");
  EXPECT_EQ(after("{}", {"/dem/through_flow=false"}), R"({"dem":{"through_flow":false}})");
  EXPECT_EQ(after("{}", {"/description=a=b"}), R"({"description":"a=b"})");
}

TEST(Overrides, ApplyInTheirOrder) {
  EXPECT_EQ(after("{}", {"/pbm/bins=8", "/pbm/bins=32"}), R"({"pbm":{"bins":32}})");
}

TEST(Overrides, ReachIntoLists) {
  const char* tasks = R"({"tasks": [{"name": "a"}, {"name": "b"}]})";

  EXPECT_EQ(after(tasks, {"/tasks/1/ranks=2"}), R"({"tasks":[{"name":"a"},{"name":"b","ranks":2}]})");
  EXPECT_EQ(after(tasks, {"/tasks/-/name=c"}), R"({"tasks":[{"name":"a"},{"name":"b"},{"name":"c"}]})");
  EXPECT_THAT(after(tasks, {"/tasks/7/name=c"}),
              testing::StartsWith("--set /tasks/7/name=c: the workflow has no such place in a list."));
  EXPECT_THAT(after("{}", {"/pbm/bins/0=8"}), testing::HasSubstr("Set the whole list."));
}

TEST(Overrides, FollowEscapedPointers) {
  EXPECT_EQ(after(R"({"tasks": [{"env": {}}]})", {"/tasks/0/env/A~1B~0C=x"}), R"({"tasks":[{"env":{"A/B~C":"x"}}]})");
}

TEST(Overrides, RefuseWhatIsNoSettingWithASuggestion) {
  EXPECT_EQ(after("{}", {"/pbm/binz=32"}), "--set /pbm/binz=32: no such setting. Did you mean /pbm/bins?");
  EXPECT_EQ(after("{}", {"/time_step=1 us"}), "--set /time_step=1 us: no such setting. Did you mean /dem/time_step?");
  EXPECT_EQ(after("{}", {"/pbm/bins/x=1"}), "--set /pbm/bins/x=1: no such setting. See docs/workflow_format.md.");
  EXPECT_EQ(after("{}", {"pbm/bins=32"}), "--set pbm/bins=32: it must be /pointer=value, such as /pbm/bins=32.");
  EXPECT_EQ(after("{}", {"/pbm/bins"}), "--set /pbm/bins: it must be /pointer=value, such as /pbm/bins=32.");
}

TEST(Overrides, LeaveTheDocumentAloneWhereTheyFail) {
  json::Value changed = document(R"({"name": "a"})");
  json::Problems problems;
  apply_overrides(changed, {"/pbm/bins/0=8", "/dem/binz=3"}, workflow_schema(), problems);

  EXPECT_EQ(problems.list().size(), 2u);
  EXPECT_EQ(json::dump(changed), R"({"name":"a"})");
}

TEST(Overrides, ReportTheirProblemsWithThoseOfTheWorkflow) {
  const auto file = std::filesystem::path(GRANARY_SOURCE_DIR) / "workflows/quick.json";
  const auto campaign = read_campaign(file, {"/dem/particels=5", "/pbm/bins=many"});

  ASSERT_FALSE(campaign.has_value());
  EXPECT_THAT(campaign.error().message,
              testing::HasSubstr("--set /dem/particels=5: no such setting. Did you mean /dem/particles?"));
  EXPECT_THAT(campaign.error().message, testing::HasSubstr("/pbm/bins is \"many\""));
}

TEST(Overrides, ChangeTheCampaign) {
  const auto file = std::filesystem::path(GRANARY_SOURCE_DIR) / "workflows/quick.json";
  const auto campaign = read_campaign(file, {"/machine/impeller_speed=60 rpm", "/pbm/bins=[20, 24]"});

  ASSERT_TRUE(campaign.has_value()) << campaign.error().message;
  EXPECT_NEAR(campaign->dem_case.machine.impeller_speed, 6.283185307, 1e-8);
  EXPECT_EQ(campaign->pbm_case.grid.bins, (std::array{20, 24}));
}

}  // namespace
}  // namespace granary::campaign
