// The section "estimation": what is fitted, to which data, in which experiments, and the problem made of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "common/json/io.hpp"
#include "controller/campaign/campaign.hpp"
#include "controller/estimation/problem_of.hpp"
#include "pbm_solver/case/pbm_case.hpp"

namespace granary::campaign {
namespace {

namespace fs = std::filesystem;
using estimation::Quantity;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

/// The workflow in which every setting is used.
Campaign complete() {
  const auto campaign = read_campaign(fs::path(GRANARY_SOURCE_DIR) / "tests/data/workflows_complete/mixer.json");
  EXPECT_TRUE(campaign) << (campaign ? "" : campaign.error().message);
  return campaign.value();
}

/// A small one that takes its rates from its own DEM, with these targets.
Result<Campaign> coupled(const std::string& targets, const std::string& further = "") {
  const fs::path file = fs::path(testing::TempDir()) / "campaign_estimation_test.json";
  std::ofstream(file) << R"({"granary": 1, "kind": "coupled", "name": "a",
      "machine": {"type": "cm5", "impeller_speed": "2000 rpm", "compartments": 4}, "feed": {"rate": "15 kg/h"},
      "spray": {"liquid_to_solid": 0.3}, "process": {"duration": "60 s", "residence_time": "5 s"},
      "pbm": {"aggregation": {"rate": 0.004}, "consolidation": {"rate": "0.1 1/s"}},
      "estimation": {"parameters": [{"name": "rate", "key": "/pbm/aggregation/rate", "from": 1e-4, "to": 1}],
                     "targets": [)"
                      << targets << "]" << further << "}}";
  return read_campaign(file);
}

constexpr const char* kD50 = R"({"quantity": "d50", "at": "60 s", "value": "85 um", "error": "5 %"})";

pbm::DemRates rates(double of) {
  pbm::DemRates rates;
  rates.diameter = {1e-4};
  rates.collision_rate = {{of}};
  rates.impact_rate = {of};
  return rates;
}

TEST(Estimation, HasParametersInTheUnitsOfTheirSettings) {
  const Estimation estimation = *complete().estimation;

  ASSERT_EQ(2u, estimation.parameters.size());
  const auto& rate = estimation.parameters[0];
  EXPECT_EQ("1/s", rate.unit);
  EXPECT_EQ("/aggregation/rate", rate.is.pointer);
  EXPECT_EQ(estimation::Scale::log, rate.is.scale);
  EXPECT_EQ(0.1, rate.is.low);
  EXPECT_EQ(3.0, rate.is.start) << "the workflow's own value";
  EXPECT_NEAR(std::log10(3.0), rate.is.prior->deviation, 1e-12);
  EXPECT_EQ(0.05, estimation.parameters[1].is.prior->deviation);
  ASSERT_EQ(2u, estimation.fixed.size());
  EXPECT_EQ(0.02, estimation.fixed[0].value);
}

TEST(Estimation, ReadsTargetsFromTheWorkflowFromCsvAndFromHdf5) {
  const auto targets = complete().estimation->targets;

  ASSERT_EQ(7u, targets.size());
  EXPECT_THAT((std::vector{targets[0].time, targets[1].time, targets[2].time}), ElementsAre(20.0, 45.0, 60.0));
  EXPECT_THAT(targets[2].value, DoubleNear(85e-6, 1e-18));
  EXPECT_THAT(targets[2].error, DoubleNear(0.04 * 85e-6, 1e-18)) << "4 % of it";
  EXPECT_EQ(2.0, targets[2].weight);
  EXPECT_EQ(estimation::kOutlet, targets[2].compartment) << "where anything flows, the outlet is meant";
  EXPECT_TRUE(targets[3].held_out);
  EXPECT_THAT(targets[4].edges, ElementsAre(DoubleNear(1e-5, 1e-18), DoubleNear(5e-5, 1e-18), DoubleNear(1e-4, 1e-18)));
  // Every 20 s at least, of 30, 60 and 75 s, up to 70 s; the third compartment's column.
  EXPECT_EQ(Quantity::porosity, targets[5].quantity);
  EXPECT_THAT((std::vector{targets[5].time, targets[6].time}), ElementsAre(30.0, 60.0));
  EXPECT_THAT((std::vector{targets[5].value, targets[6].value}), ElementsAre(0.5, 0.45));
  EXPECT_EQ(0.01, targets[5].error);
}

TEST(Estimation, AnExperimentIsTheWorkflowWithOtherSettingsAndRates) {
  const auto experiments = complete().estimation->experiments;

  ASSERT_EQ(2u, experiments.size());
  EXPECT_NEAR(0.5, experiments[1].balance.spray->rate / experiments[0].balance.spray->rate, 1e-12);
  EXPECT_EQ(20e-6, experiments[1].rates->diameter[0]);
}

TEST(Estimation, IsWrittenAndUnderstoodAgainTheSame) {
  const Campaign campaign = complete();
  const fs::path file = fs::path(testing::TempDir()) / "campaign_estimation_written.json";
  ASSERT_TRUE(json::write_file(file, to_json(campaign)));

  const auto again = read_written_campaign(file);

  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(to_json(*campaign.estimation), to_json(*again->estimation));
}

TEST(Estimation, TakesDistributionsFromBothKindsOfFiles) {
  const fs::path folder = testing::TempDir();
  std::ofstream(folder / "psd.csv")
      << "time [min];from [um];to [um];share\n0.5;20;50;0.2\n0.5;50;100;0.5\n1;20;50;0.1\n";
  fs::copy_file(fs::path(GRANARY_SOURCE_DIR) / "tests/data/workflows_complete/data/sizes.h5", folder / "psd.h5",
                fs::copy_options::overwrite_existing);

  const auto campaign = coupled(R"({"quantity": "distribution", "file": "psd.csv", "error": 0.01},
      {"quantity": "distribution", "file": "psd.h5", "dataset": "/psd/outlet", "error": 0.02, "to": "30 s"})");

  ASSERT_TRUE(campaign) << campaign.error().message;
  const auto& targets = campaign->estimation->targets;
  ASSERT_EQ(3u, targets.size());
  EXPECT_EQ(30.0, targets[0].time);
  EXPECT_THAT(targets[0].shares, ElementsAre(0.2, 0.5));
  EXPECT_THAT(targets[1].shares, ElementsAre(0.1));
  EXPECT_THAT(targets[2].shares, ElementsAre(0.4, 0.5, 0.1));
  EXPECT_EQ(20.0, targets[2].time);
  EXPECT_THAT(targets[2].edges[0], DoubleNear(20e-6, 1e-18));
  EXPECT_THAT(campaign->estimation->sources, ElementsAre("psd.csv", "psd.csv", "psd.h5"));
}

TEST(Estimation, TakesSeveralQuantitiesFromTheColumnsOfOneFileEachWithItsOwnErrors) {
  std::ofstream(fs::path(testing::TempDir()) / "all.csv")
      << "sample,time [min],d50 [um],d50_error [um],d90_laser [mm],error [%],share,from [um],to [um],share of 2\n"
         "A1,0.5,80,4,0.2,10,0.3,20,50,0.6\nA2,1,,,0.3,20,0.4,20,50,0.5\n";

  const auto campaign = coupled(R"({"quantity": "d50", "file": "all.csv"},
      {"quantity": "d90", "file": "all.csv", "column": "d90_laser"},
      {"quantity": "distribution", "file": "all.csv", "column": "share of 2", "error": 0.01})");

  ASSERT_TRUE(campaign) << campaign.error().message;
  const auto& targets = campaign->estimation->targets;
  ASSERT_EQ(5u, targets.size());
  EXPECT_THAT(targets[0].value, DoubleNear(80e-6, 1e-18));
  EXPECT_THAT(targets[0].error, DoubleNear(4e-6, 1e-18)) << "its own errors, not those of the column \"error\"";
  EXPECT_EQ(Quantity::d90, targets[1].quantity);
  EXPECT_THAT((std::vector{targets[1].value, targets[2].value}),
              ElementsAre(DoubleNear(2e-4, 1e-18), DoubleNear(3e-4, 1e-18)));
  EXPECT_THAT((std::vector{targets[1].error, targets[2].error}),
              ElementsAre(DoubleNear(2e-5, 1e-18), DoubleNear(6e-5, 1e-18)));
  EXPECT_THAT((std::vector{targets[1].time, targets[2].time}), ElementsAre(30.0, 60.0));
  EXPECT_THAT(targets[3].shares, ElementsAre(0.6));
}

TEST(Estimation, SaysWhichColumnsAFileHasWhereTheWantedOneIsMissing) {
  std::ofstream(fs::path(testing::TempDir()) / "some.csv") << "time [s],d90 [um]\n10,80\n";

  const auto campaign = coupled(R"({"quantity": "d50", "file": "some.csv", "error": "5 %"})");

  ASSERT_FALSE(campaign);
  EXPECT_THAT(campaign.error().message, HasSubstr("it has no column \"d50\"; it has: time, d90."));
}

TEST(Estimation, ASetIsRefusedByTheNameOfWhatIsWrongWithIt) {
  const auto campaign = coupled(kD50, R"(, "experiments": [{"name": "b", "set": {"/process/duration": "5 kg"}}])");

  ASSERT_FALSE(campaign);
  EXPECT_THAT(campaign.error().message, HasSubstr("/estimation/experiments/0/set"));
  EXPECT_THAT(campaign.error().message, HasSubstr("/process/duration is \"5 kg\""));
}

TEST(ProblemOf, HasASegmentForEachStretchOfTheCampaignWithItsOwnRates) {
  const auto campaign = coupled(kD50);
  ASSERT_TRUE(campaign) << campaign.error().message;

  const auto problem =
      estimating::problem_of(*campaign, {{5.0, rates(1e-12)}, {12.5, rates(2e-12)}, {0.0, rates(3e-12)}});

  ASSERT_TRUE(problem) << problem.error().message;
  const auto& segments = problem->experiments.at(0).segments;
  ASSERT_EQ(3u, segments.size());
  std::vector<double> ends, found;
  for (const json::Value& document : segments) {
    const auto segment = pbm::read_case(document, "segment");
    ASSERT_TRUE(segment) << segment.error().message;
    ends.push_back(segment->end_time);
    found.push_back(segment->dem->collision_rate[0][0]);
  }
  EXPECT_THAT(ends, ElementsAre(5.0, 12.5, 60.0));
  EXPECT_THAT(found, ElementsAre(1e-12, 2e-12, 3e-12));
  EXPECT_EQ(0.004, estimation::number_at(segments[1], problem->parameters[0].pointer));
}

TEST(ProblemOf, SaysThatThereAreNoRatesYet) {
  const auto campaign = coupled(kD50);
  ASSERT_TRUE(campaign);

  const auto problem = estimating::problem_of(*campaign);

  ASSERT_FALSE(problem);
  EXPECT_THAT(problem.error().message, HasSubstr("\"rates\""));
}

TEST(ProblemOf, AnExperimentWithRatesOfItsOwnNeedsNoDem) {
  const auto problem = estimating::problem_of(complete());

  ASSERT_TRUE(problem) << problem.error().message;
  EXPECT_EQ(2u, problem->experiments.size());
  EXPECT_EQ(1u, problem->experiments[1].segments.size());
}

}  // namespace
}  // namespace granary::campaign
