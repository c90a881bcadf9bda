#include "dem_templates/plugin/skin/skin_trial.hpp"

#include <gtest/gtest.h>

namespace granary::dem {
namespace {

// Radius 1 mm: candidates from 0.2 to 2 mm.
std::vector<Sphere> row_of(std::vector<double> places) {
  std::vector<Sphere> spheres;
  for (double x : places) spheres.push_back({{x, 0.0, 0.0}, 0.001, 0.0, 0.0});
  return spheres;
}

TEST(SkinTrial, ListsThePairsThatEachSkinReaches) {
  // gaps: -0.1 mm (they overlap), 0.5 mm, 1.5 mm, and more than 2 mm between all others
  const auto tried = try_skins(row_of({0.0, 0.0019, 0.0044, 0.0079}), 0.001, 1.0, 1e-5);

  ASSERT_EQ(tried.size(), 15u);
  EXPECT_NEAR(tried.front().skin, 0.0002, 1e-15);
  EXPECT_NEAR(tried.back().skin, 0.003, 1e-15);
  EXPECT_EQ(tried[1].pairs, 1.0);  // 0.4 mm
  EXPECT_EQ(tried[2].pairs, 2.0);  // 0.6 mm
  EXPECT_EQ(tried[6].pairs, 2.0);  // 1.4 mm
  EXPECT_EQ(tried[7].pairs, 3.0);  // 1.6 mm
  EXPECT_NEAR(tried.back().steps, 0.0015 / 1e-5, 1e-9);
}

TEST(SkinTrial, FasterParticlesWantALongerReachADenseBedAShorterOne) {
  const auto best = [](double spacing, double speed) {
    std::vector<Sphere> bed;
    for (int n = 0; n < 512; ++n)
      bed.push_back({{spacing * (n % 8), spacing * (n / 8 % 8), spacing * (n / 64)}, 0.001, 0.0, 0.0});
    return best_skin(try_skins(bed, 0.001, speed, 1e-5), 512.0);
  };

  EXPECT_EQ(best(0.002, 0.0), 0.0002);  // the list is made once
  EXPECT_LT(best(0.002, 0.5), best(0.002, 20.0));
  EXPECT_LT(best(0.002, 2.0), best(0.01, 2.0));
}

TEST(SkinTrial, ATrialOfNoParticlesIsNoFault) { EXPECT_GT(best_skin(try_skins({}, 0.001, 10.0, 1e-5), 0.0), 0.0); }

}  // namespace
}  // namespace granary::dem
