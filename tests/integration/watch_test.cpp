// granary watch beside a real campaign: as lines, on a terminal, and of a campaign that is over.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/background.hpp"
#include "tests/support/granary_program.hpp"

namespace granary {
namespace {

using test::Background;
using ::testing::HasSubstr;
using ::testing::Not;

class Watch : public ::testing::Test {
 protected:
  test::Scratch scratch;
  std::string dir = (scratch / "run").string();

  std::vector<std::string> run(const std::string& tasks) const {
    const auto file = (scratch / "workflow.json").string();
    std::ofstream(file) << R"({"granary": 1, "kind": "tasks", "name": "list", "tasks": [)" << tasks << "]}";
    return {test::kGranary, "run", file, "--dir", dir, "--cores", "2", "--quiet"};
  }
  bool is_alive() const { return test::granary_json({"status", dir, "--json"})["alive"].as_bool(); }
};

constexpr const char* kShort =
    R"({"name": "first", "command": ["sleep", "0.3"]}, {"name": "second", "command": ["sleep", "0.5"], "after": ["first"]})";

TEST_F(Watch, StartedBeforeTheCampaignPrintsLinesAndEndsWithIt) {
  Background watch({test::kGranary, "watch", dir});
  Background campaign(run(kShort));

  EXPECT_TRUE(watch.says("first finished"));
  EXPECT_EQ(0, watch.exit_code());

  EXPECT_EQ(0, campaign.exit_code());
  EXPECT_THAT(watch.output(), HasSubstr("second finished"));
  EXPECT_THAT(watch.output(), HasSubstr("All tasks finished"));
  EXPECT_THAT(watch.output(), Not(HasSubstr("\033"))) << "no order to a terminal on a pipe";
}

TEST_F(Watch, EndsWithTheExitCodeOfACampaignThatIsOver) {
  EXPECT_EQ(3, Background(run(R"({"name": "bad", "command": ["false"]})")).exit_code());

  const auto watched = test::granary({"watch", dir});

  EXPECT_EQ(3, watched.exit_code);
  EXPECT_THAT(watched.out, HasSubstr("warning: bad failed with exit code 1"));
  EXPECT_EQ(2, test::granary({"watch", (scratch / "nothing").string()}).exit_code);
}

TEST_F(Watch, OnATerminalDrawsWithoutFlickerFollowsItsSizeAndLeavesEverythingAsItWas) {
  Background campaign(run(R"({"name": "long-one", "command": ["sleep", "60"]})"));
  Background watch({test::kGranary, "watch", dir}, Background::On::terminal,
                   {"TERM=xterm-256color", "LANG=C.UTF-8", "NO_COLOR="});
  ASSERT_TRUE(watch.says("long-one")) << watch.output();
  EXPECT_THAT(watch.output(), HasSubstr("\033[?1049h")) << "the alternate screen";
  EXPECT_THAT(watch.output(), HasSubstr("\033[38;5;35mrunning"));

  watch.forget();
  watch.resize(60, 20);
  const std::string rule_of_60 = [] {
    std::string text;
    for (int k = 0; k < 60; ++k) text += "─";
    return text;
  }();
  EXPECT_TRUE(watch.says(rule_of_60 + "\033[0m\033[K"));
  EXPECT_THAT(watch.output(), Not(HasSubstr("\033[2J"))) << "never cleared between two pictures";

  watch.forget();
  watch.type("\x03");
  EXPECT_EQ(0, watch.exit_code());
  EXPECT_THAT(watch.output(), HasSubstr("\033[?25h\033[?1049l"));
  EXPECT_THAT(watch.output().substr(watch.output().find("\033[?1049l")), HasSubstr("long-one"))
      << "the last picture stays";

  EXPECT_TRUE(is_alive()) << "the campaign is left alone";
  EXPECT_EQ(0, test::granary({"stop", dir}).exit_code);
  EXPECT_EQ(4, campaign.exit_code());
}

TEST_F(Watch, OnATerminalEndsWithTheCampaignAndHasNoColourIfNoneIsWanted) {
  Background campaign(run(kShort));
  Background watch({test::kGranary, "watch", dir}, Background::On::terminal,
                   {"TERM=xterm", "LANG=C", "LC_ALL=C", "NO_COLOR=1"});

  EXPECT_EQ(0, watch.exit_code());
  EXPECT_EQ(0, campaign.exit_code());
  EXPECT_THAT(watch.output(), HasSubstr("ended (exit code 0)"));
  EXPECT_THAT(watch.output(), Not(HasSubstr("\033[38"))) << "no colour";
  EXPECT_THAT(watch.output(), Not(HasSubstr("─"))) << "ASCII where the locale says so";
}

}  // namespace
}  // namespace granary
