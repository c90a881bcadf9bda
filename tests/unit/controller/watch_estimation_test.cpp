// What the watcher shows of an estimation beside a campaign.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "controller/watch/screen.hpp"
#include "controller/watch/watcher.hpp"
#include "tests/support/granary_program.hpp"
#include "tests/support/recorded_campaign.hpp"

namespace granary::watch {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class WatchEstimation : public ::testing::Test {
 protected:
  void SetUp() override {
    campaign.write("campaign.json", R"({"understood": {"kind": "coupled", "name": "mixer", "duration_s": 60.0,
        "coupling": {"mode": "two-way"}, "dem": {}, "dem_case": {}, "pbm_case": {},
        "estimation": {"parameters": [{"key": "/pbm/aggregation/efficiency/asperity", "unit": "m"}]}}})");
    campaign.open();
    std::filesystem::create_directories(campaign.dir() / "estimation");
  }
  void evaluated(int version, int trial, const std::string& cost, double time) {
    campaign.append("estimation/evaluations.jsonl",
                    fmt::format(R"({{"version":{},"trial":{},"values":[1e-6],"cost":{},"time_s":{}}})"
                                "\n",
                                version, trial, cost, time));
  }

  test::Scratch scratch;
  test::RecordedCampaign campaign{scratch / "run"};
  Watcher watcher{campaign.dir(),
                  {[] {
                     return json::Value::object({{"alive", false}});
                   },
                   [] { return json::Value::array(); }, [] { return 0.0; }}};
};

TEST_F(WatchEstimation, HasNoFitBeforeTheFirstEvaluation) {
  campaign.append("estimation/evaluations.jsonl", "{\"problem\":1}\n{\"batch\":1,\"first\":0,\"count\":1}\n");

  EXPECT_FALSE(watcher.look().fit);
}

TEST_F(WatchEstimation, TheObjectiveFallsAndBeginsAnewWithNewRates) {
  evaluated(1, 0, "9.0", 1.0);
  evaluated(1, 1, "12.0", 2.0);
  evaluated(1, 2, "null", 3.0);
  watcher.look();
  evaluated(1, 3, "4.0", 4.0);
  evaluated(2, 4, "20.0", 5.0);

  const View view = watcher.look();

  ASSERT_TRUE(view.fit);
  EXPECT_EQ(5, view.fit->evaluations);
  std::vector<double> best;
  for (const Fit::Point& point : view.fit->points) best.push_back(point.cost);
  EXPECT_EQ(best, (std::vector{9.0, 9.0, 4.0, 20.0}));
}

TEST_F(WatchEstimation, ScreenHasParametersInTheirUnitsWithIntervals) {
  evaluated(1, 0, "9.0", 1.0);
  campaign.write("estimation/best.json", R"({"phase": "posterior", "chi_square_per_datum": 1.25, "parameters":
      [{"name": "asperity", "value": 2e-7, "low": 1e-7, "high": 3e-7}]})");

  std::string text;
  for (const Row& row : screen(watcher.look(), {100, 40}, true)) text += printed(row, 100, false) + "\n";

  EXPECT_THAT(text, HasSubstr("1.25 squares per datum after 1 evaluation, posterior"));
  EXPECT_THAT(text, HasSubstr("asperity 0.2 um (0.1 um to 0.3 um)"));
}

TEST_F(WatchEstimation, TellsWhichBurstTookWhatIsKnown) {
  campaign.record("estimation.adopted", 7.0, R"({"time_s":7.0,"burst":"0002-pbm","values":[1e-6]})");

  const View view = watcher.look();

  EXPECT_THAT(view.happenings, Contains(testing::Field(&Happening::words, HasSubstr("PBM burst 2 takes the best"))));
}

TEST_F(WatchEstimation, TheClockOfABurstIsNotThePilots) {
  campaign.record("coupling.event", 3.0, R"({"event":"task_ended","round":1,"kind":"pbm","attempt":1,"time_s":60.0})");

  EXPECT_EQ(3.0, watcher.look().time);
}

}  // namespace
}  // namespace granary::watch
