// Experiments by the solver: read off at the right times, continued over segments, given up when their time is over.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "pbm_solver/evaluate/experiment_model.hpp"
#include "pbm_solver/evaluate/twin.hpp"

namespace granary::pbm {
namespace {

using estimation::Parameter;
using estimation::Problem;
using estimation::Quantity;
using estimation::Scale;
using estimation::Target;
using ::testing::HasSubstr;

/// Constant aggregation of one class of dry particles: N(t) = N0 / (1 + N0 beta t / (2 V)).
PbmCase smoluchowski() {
  PbmCase c;
  c.grid = {{14, 1}, {1e-15, 0.0}, {2.0, 2.0}};
  c.compartments.volume = {1.0};
  c.aggregation = Aggregation{};
  c.aggregation->rate = 1e-3;
  InitialClass one;
  one.number = 1000.0;
  c.initial = {one};
  c.end_time = 4.0;
  c.relative_tolerance = 1e-4;
  return c;
}
double exact_number(double rate, double time) { return 1000.0 / (1.0 + 0.5 * 1000.0 * rate * time); }

Target target(Quantity quantity, double time, int compartment = estimation::kEverywhere) {
  Target t;
  t.experiment = "one";
  t.quantity = quantity;
  t.time = time;
  t.compartment = compartment;
  t.error = 1.0;
  return t;
}

Problem problem_of(std::vector<json::Value> segments, std::vector<Target> targets) {
  return {{{"rate", "/aggregation/rate", 1e-4, 1e-2, Scale::log, {}, {}}},
          {{"one", std::move(segments)}},
          std::move(targets)};
}

TEST(ExperimentModel, ReadsTargetsOffAtTheirTimesInTheirOrder) {
  const auto model = ExperimentModel::prepare(
      problem_of({to_json(smoluchowski())},
                 {target(Quantity::number, 3.0), target(Quantity::number, 0.0), target(Quantity::number, 1.5, 0),
                  target(Quantity::solid_mass, 2.0), target(Quantity::porosity, 2.0)}),
      "p.json");
  ASSERT_TRUE(model.has_value()) << model.error().message;
  const auto values = model->run({2e-3}, 100.0);
  ASSERT_TRUE(values.has_value()) << values.error().message;
  EXPECT_NEAR((*values)[0], exact_number(2e-3, 3.0), 2.0);
  EXPECT_EQ((*values)[1], 1000.0);
  EXPECT_NEAR((*values)[2], exact_number(2e-3, 1.5), 2.0);
  EXPECT_NEAR((*values)[3], 1000.0 * 1e-15 * 476.0, 1e-15);
  EXPECT_EQ((*values)[4], 0.0);
}

TEST(ExperimentModel, ContinuesOverSegmentsWhoseRatesDiffer) {
  PbmCase first = smoluchowski(), second = smoluchowski();
  first.end_time = 1.0;
  second.start_time = 77.0;  // not looked at
  second.end_time = 78.0;
  second.compartments.volume = {2.0};
  const auto model = ExperimentModel::prepare(
      problem_of({to_json(first), to_json(second)}, {target(Quantity::number, 1.0), target(Quantity::number, 3.0)}),
      "p.json");
  ASSERT_TRUE(model.has_value()) << model.error().message;
  const auto values = model->run({1e-3}, 100.0);
  ASSERT_TRUE(values.has_value()) << values.error().message;
  EXPECT_NEAR((*values)[0], exact_number(1e-3, 1.0), 2.0);
  EXPECT_NEAR((*values)[1], exact_number(1e-3, 2.0), 2.0);  // a second at full, two at half the rate
}

TEST(ExperimentModel, SharesOfADistributionAddUpToTheWhole) {
  Target t = target(Quantity::distribution, 2.0);
  t.edges = {1e-6, 1.3e-5, 2e-5, 1.0};
  t.shares = {0.3, 0.3, 0.4};
  const auto model = ExperimentModel::prepare(problem_of({to_json(smoluchowski())}, {t}), "p.json");
  ASSERT_TRUE(model.has_value()) << model.error().message;
  const auto values = model->run({2e-3}, 100.0);
  ASSERT_EQ(values->size(), 3u);
  EXPECT_NEAR((*values)[0] + (*values)[1] + (*values)[2], 1.0, 1e-9);
  for (const double share : *values) EXPECT_GT(share, 0.02);
}

TEST(ExperimentModel, SaysEverythingThatCannotBeReadOffAtOnce) {
  PbmCase other = smoluchowski();
  other.grid.bins = {12, 1};
  const auto model = ExperimentModel::prepare(
      problem_of({to_json(smoluchowski()), to_json(other)}, {target(Quantity::d50, -1.0), target(Quantity::d50, 1.0, 3),
                                                             target(Quantity::d50, 1.0, estimation::kOutlet)}),
      "p.json");
  ASSERT_FALSE(model.has_value());
  for (const char* part :
       {"other classes", "before the experiment's start", "compartment 3 does not exist", "of the outlet"})
    EXPECT_THAT(model.error().message, HasSubstr(part));
}

TEST(ExperimentModel, GivesATrialUpWhenItsTimeIsOver) {
  const auto model =
      ExperimentModel::prepare(problem_of({to_json(smoluchowski())}, {target(Quantity::d50, 3.0)}), "p.json");
  const auto values = model->run({2e-3}, 0.0);
  ASSERT_FALSE(values.has_value());
  EXPECT_THAT(values.error().message, HasSubstr("time of a trial was up"));
}

TEST(Twin, FitsItsOwnDataAboutAsWellAsTheirErrorsSay) {
  const Twin twin = make_twin(6, 5);
  const auto model = ExperimentModel::prepare(twin.problem, "twin");
  ASSERT_TRUE(model.has_value());
  const auto fit = estimation::fit_of(twin.problem, *model->run(twin.truth, 100.0), twin.truth);
  EXPECT_EQ(fit.residuals.size(), 40u);
  EXPECT_EQ(fit.held_out.size(), 10u);
  double sum = 0.0;
  for (const double r : fit.residuals) sum += r * r;
  EXPECT_GT(sum, 18.0);  // chi^2 of 40: 40 +- 9
  EXPECT_LT(sum, 70.0);
}

}  // namespace
}  // namespace granary::pbm
