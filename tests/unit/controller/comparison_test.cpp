#include "controller/report/comparison.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/results_example.hpp"

namespace granary::report {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kAtTheEnd = std::numeric_limits<double>::quiet_NaN();

/// The example with d50 of every compartment and of what flows out times `factor`.
NamedResults scaled(const std::string& name, double factor) {
  CampaignResults results = test::example_results();
  for (auto& row : results.pbm.d50)
    for (double& d : row) d *= factor;
  for (double& d : results.pbm.outlet_d50) d *= factor;
  return {name, results};
}

/// Only the rows before `end`.
CampaignResults cut_at(CampaignResults results, double end) {
  PbmSeries& pbm = results.pbm;
  std::size_t n = 0;
  while (n < pbm.time.size() && pbm.time[n] <= end) ++n;
  for (auto* list : {&pbm.time, &pbm.outlet_d10, &pbm.outlet_d50, &pbm.outlet_d90}) list->resize(n);
  for (auto* rows : {&pbm.d50, &pbm.number}) rows->resize(n);
  return results;
}

TEST(Comparison, OfACampaignWithItselfFindsNoDifference) {
  const auto c = compare({scaled("a", 1.0), scaled("b", 1.0)}, kAtTheEnd);
  ASSERT_TRUE(c) << c.error().message;
  EXPECT_EQ(c->runs[1].d50.largest, 0.0);
  EXPECT_EQ(c->runs[1].number_of_compartments.largest, 0.0);
  EXPECT_TRUE(c->runs[1].settings.empty());
  EXPECT_EQ(c->runs[0].outlet_d50, c->runs[1].outlet_d50);
}

TEST(Comparison, TellsADifferenceOfTenPercentAsSuch) {
  const auto c = compare({scaled("a", 1.0), scaled("b", 1.1)}, kAtTheEnd);
  ASSERT_TRUE(c);
  EXPECT_NEAR(c->runs[1].d50.mean, 0.1, 1e-12);
  EXPECT_NEAR(c->runs[1].d50.largest, 0.1, 1e-12);
  EXPECT_NEAR(c->runs[1].outlet_d50 / c->runs[0].outlet_d50, 1.1, 1e-12);
  EXPECT_THAT(table(*c), HasSubstr("(+10.0 %)"));
  EXPECT_NEAR(to_json(*c)["runs"].items()[1]["d50_difference"].number_or("mean", 0.0), 0.1, 1e-12);
}

TEST(Comparison, IsMadeWhereTheFirstOfThemEndsAndBetweenTheRowsOfTheOther) {
  const CampaignResults whole = test::example_results();
  const auto& time = whole.pbm.time;
  const std::size_t n = time.size() / 2;
  NamedResults shorter{"shorter", cut_at(whole, time[n])};
  const auto c = compare({{"whole", whole}, shorter}, kAtTheEnd);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->at, time[n]);
  EXPECT_NEAR(c->runs[0].outlet_d50, c->runs[1].outlet_d50, 1e-15);

  const double between = 0.25 * time[n - 1] + 0.75 * time[n];
  const auto earlier = compare({{"whole", whole}, shorter}, between);
  ASSERT_TRUE(earlier);
  EXPECT_NEAR(earlier->runs[1].outlet_d50, 0.25 * whole.pbm.outlet_d50[n - 1] + 0.75 * whole.pbm.outlet_d50[n], 1e-12);
}

TEST(Comparison, RefusesATimeThatOneDidNotReachAndResultsWithoutABalance) {
  NamedResults none{"none", test::example_results()};
  none.results.pbm = {};
  const auto late = compare({scaled("a", 1.0), none}, 1e9);
  ASSERT_FALSE(late);
  EXPECT_THAT(late.error().message, HasSubstr("a: it ended at"));
  EXPECT_THAT(late.error().message, HasSubstr("none: its results hold no PBM series"));
}

TEST(Comparison, NamesTheSettingsThatDiffer) {
  using json::Value;
  const Value a = Value::object({{"name", "a"}, {"dem", Value::object({{"particles", 5000}, {"ranks", 1}})}});
  const Value b = Value::object(
      {{"name", "b"}, {"dem", Value::object({{"particles", 10000}, {"ranks", 1}})}, {"estimation", Value::object()}});
  EXPECT_THAT(differing_settings(a, b), ElementsAre("/dem/particles 5000 -> 10000", "/estimation (not given) -> {}"));
}

}  // namespace
}  // namespace granary::report
