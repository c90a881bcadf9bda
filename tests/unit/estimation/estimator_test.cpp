// An estimation as a whole, on models that cost nothing: phases, intervals, warnings, lost trials, other rates.
#include "estimation/estimator/estimator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimation/search/methods.hpp"

namespace granary::estimation {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Parameter log_parameter(const std::string& name, double low, double high) {
  return {name, "/" + name, low, high, Scale::log, {}, {}};
}

/// y(t) = a exp(-k t) at t = 0 .. 19, with an error of 5 % and a seed's noise; the last five are held out.
struct Decay {
  explicit Decay(double a, double k, std::uint64_t seed) {
    Dice dice(seed);
    problem.parameters = {log_parameter("a", 0.01, 100.0), log_parameter("k", 1e-3, 1.0)};
    problem.experiments = {{"one", {}}};
    const std::vector<double> y = model({a, k});
    for (std::size_t t = 0; t < y.size(); ++t) {
      Target target;
      target.experiment = "one";
      target.value = y[t] * (1.0 + 0.05 * dice.normal());
      target.error = 0.05 * y[t];
      target.held_out = t >= 15;
      problem.targets.push_back(target);
    }
  }
  static std::vector<double> model(const std::vector<double>& p) {
    std::vector<double> y;
    for (int t = 0; t < 20; ++t) y.push_back(p[0] * std::exp(-p[1] * t));
    return y;
  }
  static Outcome outcome(const Problem& problem, const std::vector<double>& values) {
    Outcome o;
    o.model = model(values);
    Fit fit = fit_of(problem, o.model, values);
    o.residuals = fit.residuals;
    o.held_out = fit.held_out;
    return o;
  }
  Problem problem;
};

/// Runs `estimator` with `at_once` trials in flight that end in random order; every `lost`-th never comes back. Returns
/// the evaluations it took to be done.
template <class Model>
long finish(Estimator& estimator, Model model, int at_once = 4, int lost = 20, long most = 4000) {
  Dice order(17);
  std::vector<Trial> flying;
  long n = 0;
  while (estimator.phase() != Phase::done && n < most) {
    while (static_cast<int>(flying.size()) < at_once) {
      const auto asked = estimator.ask(1);
      if (asked.empty()) break;
      flying.push_back(asked[0]);
    }
    if (flying.empty()) break;
    const auto k = static_cast<std::size_t>(order.below(static_cast<int>(flying.size())));
    const Trial trial = flying[k];
    flying.erase(flying.begin() + static_cast<std::ptrdiff_t>(k));
    const bool fails = ++n % lost == 0;
    estimator.tell(trial.number, fails ? std::nullopt : std::optional(model(estimator.values_of(trial))));
  }
  return n;
}

TEST(Estimator, EndsWithIntervalsThatHoldTheTruthAndPredictsWhatWasHeldOut) {
  const Decay decay(2.0, 0.1, 3);
  Estimator estimator(decay.problem, {});
  finish(estimator, [&](const auto& v) { return Decay::outcome(decay.problem, v); });
  ASSERT_EQ(estimator.phase(), Phase::done);
  const Estimate e = estimator.estimate();
  EXPECT_TRUE(e.from_posterior);
  EXPECT_GE(e.effective_samples, 400.0);
  const double truth[] = {2.0, 0.1};
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_LT(e.low[k], truth[k]);
    EXPECT_GT(e.high[k], truth[k]);
    EXPECT_LT(e.high[k] / e.low[k], 1.3);
  }
  EXPECT_TRUE(e.unidentified.empty());
  EXPECT_GT(e.chi_square_per_datum, 0.3);
  EXPECT_LT(e.chi_square_per_datum, 2.5);
  ASSERT_TRUE(e.held_out.has_value());
  EXPECT_LT(*e.held_out, 4.0);
  EXPECT_EQ(e.model.size(), 20u);
  EXPECT_GT(estimator.failed(), 0);
}

TEST(Estimator, SaysHowManyEvaluationsThereAreAndAboutHowManyAreNeededBeforeItHasIntervals) {
  const Decay decay(2.0, 0.1, 3);
  Estimator estimator(decay.problem, {});
  for (const Trial& trial : estimator.ask(10))
    estimator.tell(trial.number, Decay::outcome(decay.problem, estimator.values_of(trial)));

  EXPECT_TRUE(estimator.estimate().low.empty());
  EXPECT_EQ("none yet: 10 evaluations, and about 214 are needed", estimator.estimate().intervals);

  const long needed = finish(estimator, [&](const auto& v) { return Decay::outcome(decay.problem, v); });
  EXPECT_GT(needed, 100);
  EXPECT_THAT(estimator.estimate().intervals, HasSubstr("of the posterior, "));
}

TEST(Estimator, DoubtsAFitThatDoesNotPredictTheHeldOutData) {
  Decay decay(2.0, 0.1, 3);
  for (Target& target : decay.problem.targets)
    if (target.held_out) target.value += 5.0 * target.error;
  Estimator estimator(decay.problem, {});
  finish(estimator, [&](const auto& v) { return Decay::outcome(decay.problem, v); });

  EXPECT_THAT(estimator.estimate().doubts, ElementsAre(HasSubstr("The 5 held-out data are not predicted")));
}

TEST(Estimator, HoldsTheTruthInNineteenOfTwentyIntervals) {
  int held = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Dice dice(seed + 500);
    const double a = std::pow(10.0, -1.0 + 2.0 * dice.uniform()), k = std::pow(10.0, -2.0 + 1.5 * dice.uniform());
    const Decay decay(a, k, seed);
    Estimator estimator(decay.problem, {Method::hybrid, seed, 3000});
    finish(estimator, [&](const auto& v) { return Decay::outcome(decay.problem, v); });
    const Estimate e = estimator.estimate();
    held += e.low[0] <= a && a <= e.high[0];
    held += e.low[1] <= k && k <= e.high[1];
    all += 2;
  }
  // 120 intervals of 95 %: 114 +- 2.4 if they were independent.
  EXPECT_GE(held, 107) << "of " << all;
  EXPECT_LT(held, all) << "intervals that always hold the truth are too wide";
}

TEST(Estimator, SaysThatOnlyAProductIsKnown) {
  Decay decay(2.0, 0.1, 3);
  decay.problem.parameters.push_back(log_parameter("psi", 0.01, 100.0));
  const auto model = [&](const std::vector<double>& v) {
    Outcome o;
    o.model = Decay::model({v[0] * v[2], v[1]});
    o.residuals = fit_of(decay.problem, o.model, v).residuals;
    return o;
  };
  Estimator estimator(decay.problem, {});
  finish(estimator, model);
  const Estimate e = estimator.estimate();
  EXPECT_THAT(e.unidentified, ElementsAre(HasSubstr("Only the product of a and psi is known")));
  EXPECT_GT(e.high[0] / e.low[0], 100.0);
  EXPECT_LT(e.high[1] / e.low[1], 2.0);
}

TEST(Estimator, AsksForTheBestPointsAgainUnderNewRatesAndIgnoresWhatComesLate) {
  const Decay before(2.0, 0.1, 3), after(3.0, 0.12, 3);
  Estimator estimator(before.problem, {});
  finish(estimator, [&](const auto& v) { return Decay::outcome(before.problem, v); });
  const std::vector<double> old_best = estimator.best()->values;
  const Trial late = estimator.ask(1)[0];

  estimator.change(after.problem, 2);
  EXPECT_FALSE(estimator.best().has_value());
  const Trial again = estimator.ask(1)[0];
  EXPECT_EQ(estimator.values_of(again), old_best);
  EXPECT_GT(again.number, late.number);
  estimator.tell(late.number, Decay::outcome(before.problem, old_best));
  EXPECT_EQ(estimator.late(), 1);
  EXPECT_FALSE(estimator.best().has_value());
  const long n = finish(estimator, [&](const auto& v) { return Decay::outcome(after.problem, v); });
  EXPECT_EQ(estimator.best()->version, 2);
  EXPECT_NEAR(estimator.best()->values[0], 3.0, 0.3);
  EXPECT_NEAR(estimator.best()->values[1], 0.12, 0.02);
  EXPECT_LT(n, 1500);
}

TEST(Estimator, GivesIntervalsWhenItsEvaluationsAreUsedUp) {
  const Decay decay(2.0, 0.1, 3);
  Estimator estimator(decay.problem, {Method::differential_evolution, 1, 60});
  const long n = finish(estimator, [&](const auto& v) { return Decay::outcome(decay.problem, v); });
  EXPECT_EQ(n, 60);
  EXPECT_EQ(estimator.phase(), Phase::done);
  EXPECT_TRUE(estimator.ask(1).empty());
  const Estimate e = estimator.estimate();
  ASSERT_EQ(e.low.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_LT(e.low[k], e.values[k]);
    EXPECT_GT(e.high[k], e.values[k]);
  }
}

TEST(Estimator, GoesOnWhereEverythingFails) {
  const Decay decay(2.0, 0.1, 3);
  Estimator estimator(decay.problem, {Method::hybrid, 1, 200});
  const long n = finish(estimator, [&](const auto&) { return Outcome{{std::nan("")}, {}, {}}; });
  EXPECT_EQ(n, 200);
  EXPECT_EQ(estimator.evaluated(), 0);
  EXPECT_EQ(estimator.estimate().trial, -1);
}

TEST(Parameters, ArePutWhereTheirPointersSayAndComeBackFromTheCube) {
  const std::vector<Parameter> parameters = {{"rate", "/aggregation/rate", 1e-4, 1.0, Scale::log, {}, {}},
                                             {"second", "/list/1", -1.0, 3.0, Scale::linear, {}, {}}};
  const json::Value made = with_parameters(json::Value::object({{"aggregation", json::Value::object({{"rate", 5}})},
                                                                {"list", json::Value(std::vector<double>{1, 2})}}),
                                           parameters, {1e-2, 0.5});
  EXPECT_EQ(number_at(made, "/aggregation/rate"), 1e-2);
  EXPECT_EQ(number_at(made, "/list/1"), 0.5);
  EXPECT_EQ(number_at(made, "/list/7"), std::nullopt);
  EXPECT_NEAR(parameters[0].place_of(1e-2), 0.5, 1e-12);
  EXPECT_NEAR(parameters[1].value_at(parameters[1].place_of(2.5)), 2.5, 1e-12);
}

TEST(Problem, SaysEverythingThatIsWrongAtOnce) {
  const auto parameter =
      json::Value::object({{"name", "rate"}, {"pointer", "/nowhere"}, {"low", 2.0}, {"high", 1.0}, {"scale", "log"}});
  const auto experiment =
      json::Value::object({{"name", "one"}, {"segments", json::Value(json::Array{json::Value::object()})}});
  const auto target =
      json::Value::object({{"experiment", "two"}, {"quantity", "d50"}, {"time", 1.0}, {"value", 1.0}, {"error", 0.0}});
  const auto problem = read_problem(json::Value::object({{"format", "granary-estimation-1"},
                                                         {"parameters", json::Value(json::Array{parameter})},
                                                         {"experiments", json::Value(json::Array{experiment})},
                                                         {"targets", json::Value(json::Array{target})}}),
                                    "p.json");
  ASSERT_FALSE(problem.has_value());
  for (const char* part :
       {"/parameters/0/high", "/experiments/0/segments", "/targets/0/error", "/targets/0/experiment"})
    EXPECT_THAT(problem.error().message, HasSubstr(part));
}

TEST(Fit, CountsSharesWeightsAndPriors) {
  Problem p;
  p.parameters = {log_parameter("a", 0.1, 10.0)};
  p.parameters[0].prior = Prior{1.0, 0.5};
  Target shares;
  shares.quantity = Quantity::distribution;
  shares.edges = {0.0, 1.0, 2.0};
  shares.shares = {0.4, 0.6};
  shares.error = 0.1;
  Target d50;
  d50.value = 2.0;
  d50.error = 0.5;
  d50.weight = 4.0;
  Target held = d50;
  held.held_out = true;
  p.targets = {shares, held, d50};
  const Fit fit = fit_of(p, {0.5, 0.5, 3.0, 2.5}, {10.0});
  EXPECT_THAT(fit.residuals, ElementsAre(testing::DoubleNear(1.0, 1e-12), testing::DoubleNear(-1.0, 1e-12), 2.0, 2.0));
  EXPECT_THAT(fit.held_out, ElementsAre(4.0));
}

}  // namespace
}  // namespace granary::estimation
