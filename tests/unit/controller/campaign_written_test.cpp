// campaign.json: what a resume reads.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"

namespace granary::campaign {
namespace {

namespace fs = std::filesystem;

class WrittenCampaign : public testing::Test {
 protected:
  const fs::path file_ = fs::path(testing::TempDir()) / "campaign.json";

  Campaign read(const std::string& name, const std::vector<std::string>& overrides = {}) {
    return read_campaign(fs::path(GRANARY_SOURCE_DIR) / "workflows" / name, overrides).value();
  }
};

TEST_F(WrittenCampaign, ReadsBackAsItWas) {
  for (const char* name : {"quick.json", "cm5.json", "pbm_only.json", "batch_bowl.json", "tasks.json"}) {
    const Campaign campaign = read(name);
    ASSERT_TRUE(json::write_file(file_, to_json(campaign)).has_value());

    const auto again = read_written_campaign(file_);

    ASSERT_TRUE(again.has_value()) << again.error().message;
    EXPECT_EQ(json::dump(to_json(*again)), json::dump(to_json(campaign)));
    EXPECT_EQ(again->file, campaign.file);
  }
}

TEST_F(WrittenCampaign, KeepsOverridesWithoutTheWorkflow) {
  const Campaign campaign = read("quick.json", {"/pbm/bins=20"});
  ASSERT_TRUE(json::write_file(file_, to_json(campaign)).has_value());

  EXPECT_EQ(read_written_campaign(file_)->pbm_case.grid.bins, (std::array{20, 20}));
}

TEST_F(WrittenCampaign, SaysVersionsAndSeeds) {
  const json::Value written = to_json(read("quick.json"));

  EXPECT_EQ(written["format"].as_string(), "granary-campaign-1");
  EXPECT_FALSE(written["version"].as_string().empty());
  EXPECT_FALSE(written["revision"].as_string().empty());
  EXPECT_EQ(written["understood"]["seeds"]["dem"].as_integer(), 86028157);
}

TEST_F(WrittenCampaign, IsNotTakenUpWhenItWouldMeanSomethingElse) {
  json::Value written = to_json(read("quick.json"));
  written.find("understood")->find("coupling")->set("threshold", 0.2);
  ASSERT_TRUE(json::write_file(file_, written).has_value());

  const auto again = read_written_campaign(file_);

  ASSERT_FALSE(again.has_value());
  EXPECT_EQ(again.error().exit, Exit::bad_input);
  EXPECT_THAT(again.error().message,
              testing::HasSubstr("campaign.json: /coupling/threshold would be understood otherwise"));
}

TEST_F(WrittenCampaign, IsToldFromOtherFiles) {
  ASSERT_TRUE(json::write_file(file_, json::Value::object({{"format", "granary-population-1"}})).has_value());

  const auto again = read_written_campaign(file_);

  ASSERT_FALSE(again.has_value());
  EXPECT_THAT(again.error().message, testing::HasSubstr("this is not a campaign.json"));
}

}  // namespace
}  // namespace granary::campaign
