// DEM -> PBM on a synthetic DEM whose rate coefficients and speeds are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/units.hpp"
#include "controller/coupling/exchange.hpp"

namespace granary::coupling {
namespace {

using ::testing::HasSubstr;

/// A bed whose particles collide at C = a wobble (d_p + d_q)^3 factor_x [m^3/s] at DEM sizes.
struct SyntheticDem {
  std::vector<double> diameter{1.0e-3, 1.6e-3, 2.5e-3, 4.0e-3};  // DEM [m]
  std::vector<double> particles{400, 300, 120, 30};              // in each compartment
  std::vector<double> bed_volume{1.0e-4, 1.5e-4, 2.0e-4};        // [m^3]
  std::vector<double> factor{1.0, 1.0, 1.0};
  double shear = 40.0;                    // a [1/s]
  double wobble = 0.3;                    // how far C is off the shape
  double impacts = 15.0;                  // per particle and time [1/s]
  double ln_mean = -0.5, ln_sigma = 0.6;  // of collision speeds
  double window = 0.01;                   // [s]
  int windows = 100;
  double f = 20.0;

  double rate(std::size_t p, std::size_t q) const {
    const double sign = (p + q) % 2 == 0 ? 1.0 : -1.0;
    return shear * (1.0 + wobble * sign) * std::pow(diameter[p] + diameter[q], 3);
  }

  double pairs(std::size_t p, std::size_t q) const {
    return p == q ? 0.5 * particles[p] * (particles[p] - 1.0) : particles[p] * particles[q];
  }

  monitor::Tallies run(unsigned seed) const {
    std::mt19937 random(seed);
    const auto poisson = [&](double mean) {
      return mean > 0.0 ? static_cast<double>(std::poisson_distribution<long>(mean)(random)) : 0.0;
    };
    std::normal_distribution<double> ln_speed(ln_mean, ln_sigma);
    const std::size_t n = diameter.size(), n_x = bed_volume.size();
    monitor::Tallies tallies;
    tallies.header.compartment_edge.assign(n_x + 1, 0.0);
    for (std::size_t x = 0; x <= n_x; ++x) tallies.header.compartment_edge[x] = 0.1 * static_cast<double>(x);
    tallies.header.class_edge.push_back(diameter.front() / 1.2);
    for (std::size_t k = 1; k < n; ++k) tallies.header.class_edge.push_back(std::sqrt(diameter[k - 1] * diameter[k]));
    tallies.header.class_edge.push_back(diameter.back() * 1.2);
    tallies.header.window = window;
    tallies.header.coarse_graining = f;
    for (int w = 0; w < windows; ++w) {
      monitor::TallyWindow made;
      made.time = window * (w + 1);
      made.window = window;
      made.particles.assign(n_x, particles);
      made.collisions.assign(n, std::vector<double>(n, 0.0));
      made.collisions_by_compartment.assign(n_x, 0.0);
      made.speed_mean.assign(n, 2.0);
      made.speed_rms.assign(n, 2.5);
      for (std::size_t x = 0; x < n_x; ++x)
        for (std::size_t p = 0; p < n; ++p)
          for (std::size_t q = p; q < n; ++q) {
            const double counted = poisson(rate(p, q) * factor[x] * pairs(p, q) * window / bed_volume[x]);
            made.collisions[p][q] += counted;
            if (p != q) made.collisions[q][p] += counted;
            made.collisions_by_compartment[x] += counted;
          }
      for (std::size_t p = 0; p < n; ++p)
        made.impacts.push_back(poisson(impacts * particles[p] * static_cast<double>(n_x) * window));
      made.impact_speed = made.collision_speed = moments(random, ln_speed);
      tallies.windows.push_back(made);
    }
    return tallies;
  }

  static monitor::SpeedMoments moments(std::mt19937& random, std::normal_distribution<double>& ln_speed) {
    constexpr int kSpeeds = 50;
    double first = 0.0, second = 0.0;
    for (int i = 0; i < kSpeeds; ++i) {
      const double x = ln_speed(random);
      first += x / kSpeeds;
      second += x * x / kSpeeds;
    }
    return {kSpeeds, first, second - first * first};
  }
};

RateSettings no_grace(const SyntheticDem& dem) {
  RateSettings settings;
  settings.grace = 0.0;
  settings.class_diameter = dem.diameter;
  return settings;
}

MeasuredRates measure(const SyntheticDem& dem, unsigned seed, const RateSettings& settings) {
  auto measured = measure_rates(dem.run(seed), dem.bed_volume, settings);
  if (!measured) ADD_FAILURE() << measured.error().message;
  return measured.value_or({});
}

TEST(Rates, ComeBackWithinTheirStandardErrors) {
  SyntheticDem dem;
  const double to_real = std::pow(dem.f, -3);
  int all = 0, within_3 = 0;
  double chi_squared = 0.0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const MeasuredRates measured = measure(dem, seed, no_grace(dem));
    for (std::size_t p = 0; p < 4; ++p)
      for (std::size_t q = p; q < 4; ++q) {
        if (measured.collisions[p][q] < 100.0) continue;
        const double off =
            (measured.rates.collision_rate[p][q] - to_real * dem.rate(p, q)) / measured.standard_error[p][q];
        ++all;
        within_3 += std::abs(off) < 3.0;
        chi_squared += off * off;
      }
  }
  ASSERT_GE(all, 150);
  EXPECT_GE(within_3, static_cast<int>(0.97 * all)) << "of " << all;
  EXPECT_NEAR(1.0, chi_squared / all, 0.35) << "the errors given are the errors made";
}

TEST(Rates, AreSymmetricAndNotNegativeAndStandAtRealSizes) {
  SyntheticDem dem;
  const MeasuredRates measured = measure(dem, 1, no_grace(dem));

  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_DOUBLE_EQ(dem.diameter[p] / 20.0, measured.rates.diameter[p]);
    for (std::size_t q = 0; q < 4; ++q) {
      EXPECT_GT(measured.rates.collision_rate[p][q], 0.0);
      EXPECT_EQ(measured.rates.collision_rate[p][q], measured.rates.collision_rate[q][p]);
    }
  }
}

TEST(Rates, TakeTheFittedShapeForAPairThatWasNeverSeen) {
  SyntheticDem dem;
  dem.wobble = 0.0;
  dem.particles[3] = 0.0;
  const MeasuredRates measured = measure(dem, 2, no_grace(dem));

  const double truth = dem.rate(3, 3) * std::pow(dem.f, -3);
  EXPECT_EQ(0.0, measured.collisions[3][3]);
  EXPECT_NEAR(truth, measured.rates.collision_rate[3][3], 0.03 * truth)
      << "the shape's error is that of all counts together";
  EXPECT_GT(measured.standard_error[3][3], 0.15 * truth) << "and it is said to be a guess";
  EXPECT_GE(measured.thin_pairs, 4);
}

TEST(Rates, GoOverSmoothlyFromTheShapeToTheCount) {
  SyntheticDem dem;
  monitor::Tallies tallies = dem.run(3);
  double last = 0.0;
  for (int extra = 0; extra <= 300; ++extra) {
    if (extra > 0) tallies.windows[0].collisions[3][3] += 1.0;
    const auto measured = measure_rates(tallies, dem.bed_volume, no_grace(dem));
    ASSERT_TRUE(measured);
    const double now = measured->rates.collision_rate[3][3];
    if (extra > 0) {
      EXPECT_GT(now, last);
      EXPECT_LT(now, 1.05 * last) << "no jump at any count";
    }
    last = now;
  }
}

TEST(Rates, FindTheCompartmentsWhereMoreHappens) {
  SyntheticDem dem;
  dem.factor = {0.5, 1.0, 2.0};
  const MeasuredRates measured = measure(dem, 4, no_grace(dem));

  const auto& factor = measured.rates.compartment_factor;
  EXPECT_NEAR(2.0, factor[1] / factor[0], 0.1);
  EXPECT_NEAR(2.0, factor[2] / factor[1], 0.1);
}

TEST(Rates, HoldACompartmentWithFewCountsNearOne) {
  SyntheticDem dem;
  dem.windows = 1;
  dem.particles = {20, 10, 2, 0};
  dem.bed_volume = {1.0e-4, 1.5e-4, 2.0e-4};
  dem.shear = 2000.0;
  const MeasuredRates measured = measure(dem, 5, no_grace(dem));

  for (const double factor : measured.rates.compartment_factor) EXPECT_NEAR(1.0, factor, 0.2);
}

TEST(Rates, PoolSpeedsAndImpactsOverTheWindows) {
  SyntheticDem dem;
  const MeasuredRates measured = measure(dem, 6, no_grace(dem));

  EXPECT_NEAR(dem.ln_mean - std::log(dem.f), measured.rates.collision_speed.ln_mean,
              3.0 * dem.ln_sigma / std::sqrt(5000.0));
  EXPECT_NEAR(dem.ln_sigma, measured.rates.collision_speed.ln_sigma, 3.0 * dem.ln_sigma / std::sqrt(2.0 * 5000.0));
  EXPECT_NEAR(dem.ln_mean, measured.rates.impact_speed.ln_mean, 3.0 * dem.ln_sigma / std::sqrt(5000.0))
      << "the wall is as fast as ever";
  for (std::size_t p = 0; p < 4; ++p)
    EXPECT_NEAR(dem.impacts, measured.rates.impact_rate[p], 3.0 * dem.impacts / std::sqrt(measured.impacts[p]))
        << "class " << p;
}

/// Collisions of one real particle of class p with all others, per time, as a PBM would compute it from the rates
/// [1/s].
double collision_frequency(const MeasuredRates& measured, const SyntheticDem& dem, std::size_t p) {
  double frequency = 0.0;
  const double real = std::pow(dem.f, 3);
  for (std::size_t q = 0; q < 4; ++q)
    frequency +=
        measured.rates.collision_rate[p][q] * real * (dem.particles[q] - (p == q ? 1.0 : 0.0)) / dem.bed_volume[0];
  return frequency;
}

TEST(CoarseGraining, LeavesTheParticlesCollisionFrequencyAsItWas) {
  SyntheticDem fine;
  fine.f = 10.0;
  fine.windows = 400;
  SyntheticDem coarse =
      fine;  // the same real bed, half as fine: 8 times fewer particles, twice as large, at the same shear rate
  coarse.f = 20.0;
  for (std::size_t p = 0; p < 4; ++p) {
    coarse.diameter[p] *= 2.0;
    fine.particles[p] = 8.0 * coarse.particles[p];
  }
  coarse.ln_mean += std::log(2.0);
  const MeasuredRates of_fine = measure(fine, 8, no_grace(fine)), of_coarse = measure(coarse, 9, no_grace(coarse));

  for (std::size_t p = 0; p < 4; ++p)
    EXPECT_NEAR(1.0, collision_frequency(of_coarse, coarse, p) / collision_frequency(of_fine, fine, p), 0.06)
        << "class " << p;
  EXPECT_NEAR(1.0, of_coarse.summary.collision_frequency / of_fine.summary.collision_frequency, 0.02);
  EXPECT_NEAR(of_fine.rates.collision_speed.ln_mean, of_coarse.rates.collision_speed.ln_mean, 0.02);
  EXPECT_EQ(nullptr, compare(of_fine.summary, of_coarse.summary).beyond(0.02, 3.0))
      << "a change of f is no change of the process";
}

TEST(CoarseGraining, ScalesByTheSquareAtEqualSpeed) {
  SyntheticDem dem;
  RateSettings settings = no_grace(dem);
  const MeasuredRates orthokinetic = measure(dem, 10, settings);
  settings.law = ScalingLaw::equal_speed;
  const MeasuredRates equal_speed = measure(dem, 10, settings);

  EXPECT_NEAR(dem.f, equal_speed.rates.collision_rate[0][1] / orthokinetic.rates.collision_rate[0][1], 0.02 * dem.f);
  EXPECT_NEAR(dem.ln_mean, equal_speed.rates.collision_speed.ln_mean, 0.03);
  EXPECT_NEAR(dem.f, equal_speed.summary.collision_frequency / orthokinetic.summary.collision_frequency, 1e-9);
}

// The same powder at two coarse grainings, in a machine where C goes as f^2.2, speeds as f^0.8 and impacts as f^1.1.
TEST(CoarseGraining, MakesNoDifferenceWithTheLawThatALadderHasFound) {
  SyntheticDem fine;
  fine.f = 10.0;
  fine.windows = 400;
  SyntheticDem coarse = fine;
  coarse.f = 20.0;
  for (std::size_t p = 0; p < 4; ++p) {
    coarse.diameter[p] *= 2.0;
    fine.particles[p] = 8.0 * coarse.particles[p];
  }
  coarse.shear *= std::pow(2.0, 2.2 - 3.0);
  coarse.ln_mean += 0.8 * std::log(2.0);
  coarse.impacts *= std::pow(2.0, 1.1);
  const auto taken_to = [](const SyntheticDem& dem, double at) {
    RateSettings settings = no_grace(dem);
    settings.found = {at, 2.2, 0.8, 1.1, 0.8};
    return settings;
  };
  const MeasuredRates of_fine = measure(fine, 8, taken_to(fine, 10.0)), at_once = measure(fine, 8, no_grace(fine)),
                      of_coarse = measure(coarse, 9, taken_to(coarse, 10.0));

  for (std::size_t p = 0; p < 4; ++p) {
    EXPECT_NEAR(1.0, collision_frequency(of_coarse, coarse, p) / collision_frequency(of_fine, fine, p), 0.06);
    EXPECT_NEAR(1.0, of_coarse.rates.impact_rate[p] / of_fine.rates.impact_rate[p], 0.1);
    EXPECT_DOUBLE_EQ(at_once.rates.impact_rate[p], of_fine.rates.impact_rate[p]) << "where it is taken to, it stays";
  }
  EXPECT_NEAR(of_fine.rates.collision_speed.ln_mean, of_coarse.rates.collision_speed.ln_mean, 0.02);
  EXPECT_NEAR(of_fine.rates.impact_speed.ln_mean, of_coarse.rates.impact_speed.ln_mean, 0.02);
  EXPECT_NEAR(of_fine.shape_rate, of_coarse.shape_rate, 0.02 * of_fine.shape_rate);
  EXPECT_EQ(nullptr, compare(of_fine.summary, of_coarse.summary).beyond(0.02, 3.0));
  EXPECT_DOUBLE_EQ(at_once.rates.collision_rate[0][1], of_fine.rates.collision_rate[0][1]);
}

// Bursts of the same bed, whose mean speed wanders as flocks of particles do: two of them differ by what they say.
TEST(Rates, KnowAMeanSpeedAsWellAsTheWindowsScatterAllows) {
  SyntheticDem dem;
  dem.windows = 12;
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 0.2);
  double by_error = 0.0, by_counting = 0.0;
  constexpr int kPairs = 100;
  const auto burst = [&](unsigned seed) {
    monitor::Tallies tallies = dem.run(seed);
    double off = normal(random);
    for (auto& window : tallies.windows) {
      window.speed_mean[1] = 2.0 + off;
      off = 0.6 * off + 0.8 * normal(random);
    }
    return measure_rates(tallies, dem.bed_volume, no_grace(dem)).value_or(MeasuredRates{}).summary;
  };
  const double counting = std::sqrt((2.5 * 2.5 - 2.0 * 2.0) / (3.0 * dem.particles[1]));  // of one burst
  for (unsigned k = 0; k < kPairs; ++k) {
    const DemSummary a = burst(2 * k), b = burst(2 * k + 1);
    ASSERT_EQ(a.mean_speed.size(), 4u);
    EXPECT_NEAR(a.mean_speed_error[0], std::sqrt((2.5 * 2.5 - 2.0 * 2.0) / (3.0 * dem.particles[0])), 1e-9);
    const double change = a.mean_speed[1] - b.mean_speed[1];
    by_error += std::pow(change / std::hypot(a.mean_speed_error[1], b.mean_speed_error[1]), 2) / kPairs;
    by_counting += 0.5 * std::pow(change / counting, 2) / kPairs;
  }
  EXPECT_GT(by_counting, 2.5);
  EXPECT_GT(by_error, 0.4);
  EXPECT_LT(by_error, 1.5);
}

TEST(Rates, LeaveOutTheGraceTime) {
  SyntheticDem dem;
  monitor::Tallies tallies = dem.run(11);
  for (int w = 0; w < 20; ++w)
    for (auto& row : tallies.windows[static_cast<std::size_t>(w)].collisions)
      for (double& count : row) count *= 10.0;
  RateSettings settings = no_grace(dem);
  settings.grace = 0.2;

  const auto measured = measure_rates(tallies, dem.bed_volume, settings);

  ASSERT_TRUE(measured);
  EXPECT_EQ(80u, measured->windows);
  const double truth = dem.rate(0, 1) * std::pow(dem.f, -3);
  EXPECT_NEAR(truth, measured->rates.collision_rate[0][1], 4.0 * measured->standard_error[0][1]);
}

TEST(Rates, SayWhatIsMissing) {
  SyntheticDem dem;
  const auto message = [&](const monitor::Tallies& tallies, const std::vector<double>& volumes, double grace) {
    RateSettings settings = no_grace(dem);
    settings.grace = grace;
    const auto measured = measure_rates(tallies, volumes, settings);
    return measured ? std::string("no error") : measured.error().message;
  };
  const monitor::Tallies good = dem.run(12);
  EXPECT_EQ("no error", message(good, dem.bed_volume, 0.0));
  EXPECT_THAT(message(good, dem.bed_volume, 2.0), HasSubstr("no DEM window begins after the grace time of 2 s"));
  EXPECT_THAT(message(good, {1e-4}, 0.0), HasSubstr("tallied in 3 compartments, the PBM has 1"));
  EXPECT_THAT(message(good, {1e-4, 0.0, 1e-4}, 0.0), HasSubstr("bed volume of compartment 2 is 0"));
  monitor::Tallies still = good;
  for (auto& window : still.windows)
    for (auto& row : window.collisions) row.assign(4, 0.0);
  EXPECT_THAT(message(still, dem.bed_volume, 0.0), HasSubstr("no collision was counted in 100 DEM windows"));
  monitor::Tallies bad = good;
  bad.diverged = monitor::Divergence{"overlap", "largest overlap 0.4", 0.1, {}};
  EXPECT_THAT(message(bad, dem.bed_volume, 0.0), HasSubstr("diverged (overlap)"));
}

TEST(Comparison, NeedsAChangeBeyondToleranceAndNoise) {
  DemSummary before{0, 1, 20, 1000, 50.0, 20.0, 400, 1e6, {1e-4}, {2.0}, {0.0}};
  DemSummary after = before;
  after.collision_frequency = 55.0;  // 10 % more, but of 400 counts: 7 % noise
  EXPECT_EQ(nullptr, compare(before, after).beyond(0.05, 3.0));
  before.collisions = after.collisions = 1e6;
  const Change change = compare(before, after);
  ASSERT_NE(nullptr, change.beyond(0.05, 3.0));
  EXPECT_EQ("collision_frequency", change.beyond(0.05, 3.0)->what);
  EXPECT_NEAR(0.1, change.largest()->change, 1e-12);
}

TEST(Comparison, LeavesOutCompartmentsThatAreEmptyInBoth) {
  const PbmSummary before{10.0, {1e-4, 1e-5, 0.0}, {1e9, 10.0, 0.0}},
      after{20.0, {1.01e-4, 5e-5, 0.0}, {1e9, 20.0, 0.0}};
  EXPECT_NEAR(0.01, compare(before, after).largest()->change, 1e-9);
  const PbmSummary filled{20.0, {1e-4, 1e-4, 0.0}, {1e9, 1e9, 0.0}};
  EXPECT_GT(compare(before, filled).largest()->change, 1.0);
}

}  // namespace
}  // namespace granary::coupling
