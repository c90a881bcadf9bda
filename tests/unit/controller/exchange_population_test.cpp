// PBM -> DEM: particles that stand for a population balance.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "common/math/size_distribution.hpp"
#include "controller/coupling/exchange.hpp"

namespace granary::coupling {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

HoldUp an_empty_hold_up(std::size_t n_x, std::size_t n = 16) {
  HoldUp hold_up;
  for (std::size_t i = 0; i < n; ++i) hold_up.solid_1.push_back(5e-16 * std::pow(3.0, static_cast<double>(i)));
  hold_up.solid_2 = hold_up.solid_1;
  const Matrix none(n, std::vector<double>(n, 0.0));
  hold_up.number = hold_up.liquid = hold_up.gas = std::vector<Matrix>(n_x, none);
  return hold_up;
}

/// A broad distribution: number falls with the square of the volume, so volume is spread over many classes.
HoldUp a_random_hold_up(unsigned seed, std::size_t n_x = 4) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<> some(0.0, 1.0);
  HoldUp hold_up = an_empty_hold_up(n_x);
  for (std::size_t x = 0; x < n_x; ++x)
    for (std::size_t i = 0; i < 10; ++i)
      for (std::size_t j = 0; j < 10; ++j) {
        const double solid = hold_up.solid_1[i] + hold_up.solid_2[j];
        hold_up.number[x][i][j] = 1e-6 * some(random) / solid;
        hold_up.liquid[x][i][j] = 0.3 * some(random) * hold_up.number[x][i][j] * solid;
        hold_up.gas[x][i][j] = 0.5 * some(random) * hold_up.number[x][i][j] * solid;
      }
  return hold_up;
}

PopulationSettings settings_for(const HoldUp& hold_up) {
  PopulationSettings settings;
  settings.budget = 4000;
  for (std::size_t x = 0; x <= hold_up.n_compartments(); ++x)
    settings.compartment_edge.push_back(0.1 * static_cast<double>(x));
  return settings;
}

SampledPopulation sample(const HoldUp& hold_up, const PopulationSettings& settings) {
  auto sampled = sample_population(hold_up, settings);
  if (!sampled) ADD_FAILURE() << sampled.error().message;
  return sampled.value_or({});
}

double volume(const dem::Population& population) {
  double total = 0.0;
  for (std::size_t k = 0; k < population.count.size(); ++k)
    total += static_cast<double>(population.count[k]) * sphere_volume(population.diameter[k]);
  return total;
}

double finest_volume(const dem::Population& population) {
  for (std::size_t k = 0; k < population.count.size(); ++k)
    if (population.count[k] > 0) return sphere_volume(population.diameter[k]);
  return 0.0;
}

TEST(Population, KeepsTheHoldUpOfEachCompartmentUpToHalfAParticle) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const HoldUp hold_up = a_random_hold_up(seed);
    const SampledPopulation sampled = sample(hold_up, settings_for(hold_up));

    for (std::size_t x = 0; x < hold_up.n_compartments(); ++x)
      EXPECT_NEAR(hold_up.volume(x), volume(sampled.compartments[x]),
                  0.5000001 * finest_volume(sampled.compartments[x]))
          << "seed " << seed;
    EXPECT_LT(sampled.volume_error, 1e-3);
  }
}

TEST(Population, StaysWithinTheBudgetAndAimsAtThreeQuarters) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const HoldUp hold_up = a_random_hold_up(seed);
    PopulationSettings settings = settings_for(hold_up);
    settings.budget = 1000 + 200 * static_cast<long>(seed);
    const SampledPopulation sampled = sample(hold_up, settings);

    const double share = static_cast<double>(sampled.total) / static_cast<double>(settings.budget);
    EXPECT_GE(sampled.coarse_graining, 1.0);
    EXPECT_GT(share, 0.5) << sampled.choice;
    EXPECT_LE(share, 1.0) << sampled.choice;
    if (settings.budget < 4000) continue;  // a small budget is at the mercy of single coarse particles
    EXPECT_NEAR(0.75, share, 0.05);
  }
}

TEST(Population, KeepsToTheBudgetWithWholeParticlesToo) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const HoldUp hold_up = a_random_hold_up(seed, 16);
    PopulationSettings settings = settings_for(hold_up);
    settings.budget = 300;
    settings.size_classes = 4;
    if (const auto sampled = sample_population(hold_up, settings))
      EXPECT_LE(sampled->total, 300) << sampled->choice;
    else
      ADD_FAILURE() << sampled.error().message;
  }
}

TEST(Population, HasTheRightNumberOfEachSizeToo) {
  const HoldUp hold_up = a_random_hold_up(3);
  PopulationSettings settings = settings_for(hold_up);
  settings.fine_cut = 0.0;
  const SampledPopulation sampled = sample(hold_up, settings);

  double real = 0.0;
  for (const double number : summarize(hold_up).number) real += number;
  const double stands_for = static_cast<double>(sampled.total) * std::pow(sampled.coarse_graining, 3);
  EXPECT_NEAR(1.0, stands_for / real, 0.02) << "a class's diameter is that of its mean volume";
  EXPECT_EQ(0.0, sampled.unrepresented_volume);
  EXPECT_EQ(0.0, sampled.unrepresented_number);
}

TEST(Population, SaysWhatTheFineTailWas) {
  HoldUp hold_up = an_empty_hold_up(1);
  hold_up.number[0][6][6] = 48e-6 / (2.0 * hold_up.solid_1[6]);
  hold_up.number[0][0][0] = 2e-6 / (2.0 * hold_up.solid_1[0]);
  const SampledPopulation sampled = sample(hold_up, settings_for(hold_up));

  EXPECT_NEAR(0.04, sampled.unrepresented_volume, 1e-9);
  EXPECT_NEAR(1.0 - 24.0 / (24.0 + 729.0), sampled.unrepresented_number, 1e-3)
      << "729 small ones have the volume of a large one";
  ASSERT_EQ(1u, sampled.class_diameter.size());
  EXPECT_NEAR(sphere_diameter(2.0 * hold_up.solid_1[6]), sampled.class_diameter[0] / sampled.coarse_graining, 1e-12);
}

TEST(Population, KeepsTheCoarseGrainingWhileTheCountIsWithinBounds) {
  const HoldUp hold_up = a_random_hold_up(5);
  PopulationSettings settings = settings_for(hold_up);
  const double chosen = sample(hold_up, settings).coarse_graining;
  const auto with_previous = [&](double f) {
    settings.previous_coarse_graining = f;
    return sample(hold_up, settings);
  };

  EXPECT_EQ(chosen * 1.1, with_previous(chosen * 1.1).coarse_graining) << "0.56 of the budget";
  EXPECT_FALSE(with_previous(chosen * 1.1).coarse_graining_changed);
  EXPECT_EQ(chosen, with_previous(chosen * 1.2).coarse_graining) << "0.43 of the budget: chosen anew";
  EXPECT_EQ(chosen, with_previous(chosen * 0.9).coarse_graining) << "1.03 of the budget";
  EXPECT_TRUE(with_previous(chosen * 0.9).coarse_graining_changed);
}

TEST(Population, IsRealWhereTheBudgetAllowsIt) {
  HoldUp hold_up = an_empty_hold_up(1);
  hold_up.number[0][8][8] = 900.0;
  const SampledPopulation sampled = sample(hold_up, settings_for(hold_up));

  EXPECT_EQ(1.0, sampled.coarse_graining);
  EXPECT_EQ(900, sampled.total);
}

TEST(Population, LeavesEmptyCompartmentsEmpty) {
  HoldUp hold_up = a_random_hold_up(6);
  hold_up.number[2] = hold_up.liquid[2] = hold_up.gas[2] = Matrix(16, std::vector<double>(16, 0.0));
  const SampledPopulation sampled = sample(hold_up, settings_for(hold_up));

  for (const long count : sampled.compartments[2].count) EXPECT_EQ(0, count);
  EXPECT_EQ(0.2, sampled.compartments[2].from);
  EXPECT_EQ(0.3, std::round(sampled.compartments[2].to * 1e12) / 1e12);
}

TEST(Population, HasEachCompartmentsOwnSizes) {
  HoldUp hold_up = an_empty_hold_up(2);
  hold_up.number[0][3][3] = 1e-6 / hold_up.solid_1[3];
  hold_up.number[1][6][6] = 1e-6 / hold_up.solid_1[6];
  PopulationSettings settings = settings_for(hold_up);
  const SampledPopulation sampled = sample(hold_up, settings);

  ASSERT_EQ(2u, sampled.class_diameter.size());
  EXPECT_GT(sampled.compartments[0].count[0], 0);
  EXPECT_EQ(0, sampled.compartments[0].count[1]);
  EXPECT_EQ(0, sampled.compartments[1].count[0]);
  EXPECT_GT(sampled.compartments[1].count[1], 0);
  EXPECT_NEAR(
      27.0,
      static_cast<double>(sampled.compartments[0].count[0]) / static_cast<double>(sampled.compartments[1].count[1]),
      0.5);
}

TEST(Population, GivesEachClassAboutTheSameVolume) {
  const HoldUp hold_up = a_random_hold_up(7);
  const SampledPopulation sampled = sample(hold_up, settings_for(hold_up));

  ASSERT_EQ(6u, sampled.class_diameter.size());
  for (std::size_t k = 0; k < 6; ++k) {
    double of_class = 0.0;
    for (const dem::Population& compartment : sampled.compartments)
      of_class += static_cast<double>(compartment.count[k]) * sphere_volume(compartment.diameter[k]);
    EXPECT_NEAR(1.0 / 6.0, of_class / sampled.volume, 0.08) << "class " << k;
  }
}

TEST(Population, PutsEachClassBetweenItsEdges) {
  const HoldUp hold_up = a_random_hold_up(8);
  const SampledPopulation sampled = sample(hold_up, settings_for(hold_up));

  ASSERT_EQ(sampled.class_diameter.size() + 1, sampled.class_edge.size());
  for (std::size_t k = 0; k < sampled.class_diameter.size(); ++k) {
    EXPECT_LT(sampled.class_edge[k], sampled.class_diameter[k]);
    EXPECT_GT(sampled.class_edge[k + 1], sampled.class_diameter[k]);
  }
}

TEST(Population, CutsMoreOfTheFineTailToFitTheMachine) {
  const HoldUp hold_up = a_random_hold_up(9);
  PopulationSettings settings = settings_for(hold_up);
  const SampledPopulation free = sample(hold_up, settings);
  settings.largest_diameter = 0.7 * free.class_diameter.back();
  const SampledPopulation bounded = sample(hold_up, settings);

  EXPECT_LE(bounded.class_diameter.back(), settings.largest_diameter);
  EXPECT_LE(bounded.total, settings.budget);
  EXPECT_GT(bounded.unrepresented_volume, free.unrepresented_volume);
  EXPECT_THAT(bounded.choice, HasSubstr("rides on the finest class"));
}

TEST(Population, ShowsWhatIsTooLargeForTheMachineAtTheBound) {
  HoldUp hold_up = a_random_hold_up(9);
  hold_up.number[1][12][12] = 1e-4 / hold_up.solid_1[12];  // half of all in lumps of 1 mm
  PopulationSettings settings = settings_for(hold_up);
  settings.largest_diameter = 0.012;
  const SampledPopulation bounded = sample(hold_up, settings);

  EXPECT_LE(bounded.class_diameter.back(), 0.012 * (1.0 + 1e-12));
  EXPECT_LE(bounded.total, settings.budget);
  EXPECT_GT(bounded.capped_volume, 0.0);
  EXPECT_THAT(bounded.choice, HasSubstr("larger than the machine allows"));
  for (std::size_t x = 0; x < hold_up.n_compartments(); ++x)
    EXPECT_NEAR(hold_up.volume(x), volume(bounded.compartments[x]), 0.5000001 * finest_volume(bounded.compartments[x]));
}

TEST(Population, SaysHowManyParticlesItWouldTake) {
  const HoldUp hold_up = a_random_hold_up(10);
  PopulationSettings settings = settings_for(hold_up);
  settings.largest_diameter = 1e-4;
  const auto sampled = sample_population(hold_up, settings);

  ASSERT_FALSE(sampled);
  EXPECT_THAT(sampled.error().message,
              AllOf(HasSubstr("cannot be shown with 4000 particles of at most 0.0001 m"), HasSubstr("/dem/particles")));
}

TEST(Population, WeighsSolidsAndLiquidOverTheWholeVolume) {
  HoldUp hold_up = an_empty_hold_up(1);
  const double solid = 2.0 * hold_up.solid_1[5];
  hold_up.number[0][5][5] = 1e6;
  hold_up.liquid[0][5][5] = 1e6 * 0.25 * solid;
  hold_up.gas[0][5][5] = 1e6 * 0.75 * solid;
  PopulationSettings settings = settings_for(hold_up);
  settings.solid_density = {400.0, 600.0};

  EXPECT_NEAR((500.0 + 0.25 * 1000.0) / 2.0, sample(hold_up, settings).density, 1e-9);
}

TEST(Population, RefusesAStateThatIsNotOne) {
  const auto message = [](const HoldUp& hold_up) {
    const auto sampled = sample_population(hold_up, settings_for(hold_up));
    return sampled ? std::string("no error") : sampled.error().message;
  };
  HoldUp bad = a_random_hold_up(11);
  bad.number[1][2][3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message(bad), HasSubstr("number = nan in compartment 2, class (3, 4)"));
  bad.number[1][2][3] = -1.0;
  EXPECT_THAT(message(bad), HasSubstr("number = -1 in compartment 2"));
  EXPECT_THAT(message(an_empty_hold_up(2)), HasSubstr("holds no particles"));
}

TEST(Population, HandsItsSizesOnThroughItsRecord) {
  const HoldUp hold_up = a_random_hold_up(12);
  const SampledPopulation sampled = sample(hold_up, settings_for(hold_up));
  const json::Value record = to_json(sampled);

  EXPECT_EQ(sampled.class_diameter, record.numbers("class_diameter_m"))
      << "the rates of this burst are measured at these sizes";
  EXPECT_EQ(sampled.coarse_graining, record.number_or("coarse_graining", 0.0))
      << "the next burst keeps this f if it can";
}

pbm::PbmCase the_published_feed() {
  pbm::PbmCase pbm_case;
  pbm_case.compartments.count = 16;
  pbm_case.compartments.residence_time = 49.0;
  pbm_case.feed.emplace();
  const std::vector<double> rates{726657587, 286654401, 118218011, 50319795, 20954036, 7345998, 1500147, 76518, 149};
  for (int k = 0; k < 9; ++k) pbm_case.feed->classes.push_back({k, k, rates[static_cast<std::size_t>(k)]});
  return pbm_case;
}

TEST(StartingHoldUp, HoldsTheFeedOfOneResidenceTime) {
  const auto hold_up = starting_hold_up(the_published_feed());

  ASSERT_TRUE(hold_up);
  double volume = 0.0;
  for (std::size_t x = 0; x < 16; ++x) volume += hold_up->volume(x);
  EXPECT_NEAR(15.0 / 3600.0 * 49.0, volume * 476.0, 1e-5) << "15 kg/h for 49 s";
  EXPECT_NEAR(volume / 16.0, hold_up->volume(7), 1e-12);
  EXPECT_NEAR(48.389e-6, summarize(*hold_up).d50[0], 1e-9)
      << "half the volume is reached within the cell of the 53.7 um class";
}

TEST(StartingHoldUp, PrefersTheInitialClasses) {
  pbm::PbmCase pbm_case = the_published_feed();
  pbm_case.initial = {{-1, 2, 2, 1000.0, 1e-12, 2e-12}, {3, 4, 4, 50.0, 0.0, 0.0}};
  const auto hold_up = starting_hold_up(pbm_case);

  ASSERT_TRUE(hold_up);
  EXPECT_EQ(1000.0, hold_up->number[0][2][2]);
  EXPECT_EQ(0.0, hold_up->number[0][4][4]);
  EXPECT_EQ(50.0, hold_up->number[3][4][4]);
  EXPECT_EQ(2e-12, hold_up->gas[15][2][2]);
}

TEST(StartingHoldUp, SaysWhatIsMissing) {
  pbm::PbmCase pbm_case = the_published_feed();
  pbm_case.compartments.residence_time.reset();
  const auto none = starting_hold_up(pbm_case);

  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("/charge"));
}

}  // namespace
}  // namespace granary::coupling
