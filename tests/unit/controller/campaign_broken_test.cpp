// A folder of broken workflows, each with exactly the messages it gets.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "controller/campaign/campaign.hpp"

namespace granary::campaign {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class BrokenWorkflows : public testing::Test {
 protected:
  void SetUp() override { fs::current_path(fs::path(GRANARY_SOURCE_DIR) / "tests/data/workflows_broken"); }
};

TEST_F(BrokenWorkflows, EachGetsExactlyItsMessages) {
  int n = 0;
  for (const auto& entry : fs::directory_iterator(".")) {
    if (entry.path().extension() != ".json") continue;
    ++n;
    const fs::path file = entry.path().filename();
    const auto campaign = read_campaign(file);
    ASSERT_FALSE(campaign.has_value()) << file;
    EXPECT_EQ(campaign.error().exit, Exit::bad_input) << file;
    EXPECT_EQ(campaign.error().message + "\n", text_of(fs::path(file).replace_extension(".expected"))) << file;
  }
  EXPECT_GE(n, 50);
}

TEST_F(BrokenWorkflows, AMissingFileIsNamed) {
  const auto campaign = read_campaign("nothing_here.json");

  ASSERT_FALSE(campaign.has_value());
  EXPECT_EQ(campaign.error().exit, Exit::bad_input);
  EXPECT_NE(campaign.error().message.find("nothing_here.json"), std::string::npos) << campaign.error().message;
}

TEST_F(BrokenWorkflows, TheFileIsNamedAsTheCallerNamedIt) {
  const auto campaign = read_campaign("../workflows_broken/zero_particles.json");

  ASSERT_FALSE(campaign.has_value());
  EXPECT_EQ(campaign.error().message.rfind("../workflows_broken/zero_particles.json: /dem/particles is 0", 0), 0u);
}

}  // namespace
}  // namespace granary::campaign
