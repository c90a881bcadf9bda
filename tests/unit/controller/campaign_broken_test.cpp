// A folder of broken workflows, each with exactly the messages it gets.
#include <gtest/gtest.h>

#include "common/files.hpp"
#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"

namespace granary::campaign {
namespace {

namespace fs = std::filesystem;

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
    EXPECT_EQ(campaign.error().message + "\n", read_text(fs::path(file).replace_extension(".expected")).value())
        << file;
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

/// Pointers of all members and items of a document.
void collect(const json::Value& value, const std::string& at, std::vector<std::string>& pointers) {
  if (!at.empty()) pointers.push_back(at);
  if (value.is_object())
    for (const auto& [key, child] : value.members()) collect(child, at + "/" + key, pointers);
  if (value.is_array())
    for (std::size_t i = 0; i < value.size(); ++i) collect(value.items()[i], at + "/" + std::to_string(i), pointers);
}

TEST_F(BrokenWorkflows, AnyValueAnywhereIsReadOrRefusedInOurOwnWords) {
  const std::vector<std::string> replacements{"null", "true", "-1", "1e300", "\"\"", "\"1 kg\"", "[null, {}]", "{}"};
  int read = 0, refused = 0;
  for (const char* name : {"mixer.json", "bowl.json", "tasks.json", "sweep_pbm.json", "sweep_dem.json"}) {
    const fs::path file = fs::path("../workflows_complete") / name;
    std::vector<std::string> pointers;
    collect(json::read_file(file).value(), "", pointers);
    for (const std::string& pointer : pointers) {
      for (const std::string& value : replacements) {
        const auto campaign = read_campaign(file, {pointer + "=" + value});
        ++(campaign ? read : refused);
        if (campaign) continue;
        EXPECT_EQ(campaign.error().exit, Exit::bad_input) << pointer << "=" << value;
        EXPECT_FALSE(campaign.error().message.empty());
        // The schema's own messages ("Failed to match ...") mean that the reader let something pass that it should not.
        EXPECT_EQ(campaign.error().message.find("Failed"), std::string::npos) << pointer << "=" << value << "\n"
                                                                              << campaign.error().message;
      }
    }
  }
  EXPECT_GT(read, 30);
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace granary::campaign
