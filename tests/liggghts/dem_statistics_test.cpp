// The machines with our walls beside the same machines with LIGGGHTS' own: a short form of `granary bench dem --only
// comparison`. Bounds are Student's t for a false alarm in less than 1 of 1000 tests.
#include <cmath>

#include <gtest/gtest.h>

#include "controller/bench/dem_cases.hpp"
#include "controller/bench/dem_comparison.hpp"
#include "controller/bench/dem_run.hpp"
#include "controller/bench/scratch_folder.hpp"

namespace granary::bench {
namespace {

const std::vector<std::string> kLookedAt{"collisions", "collision speed", "impacts", "impact speed"};
constexpr double kChance = 1e-3;
constexpr int kSeeds = 4;

dem::DemCase measured_for(dem::DemCase c, double settle, int turns) {
  c.time_step = 8e-6;
  c.settle_time = settle;
  c.duration = turns * turn_of(c);
  return c;
}

Comparison result_of(const Result<Comparison>& compared) {
  EXPECT_TRUE(compared) << (compared ? "" : compared.error().message);
  return compared ? *compared : Comparison{};
}

void expect_agreement(const Comparison& compared) {
  ASSERT_EQ(compared.all.size(), kLookedAt.size());
  for (const Difference& d : compared.all) {
    EXPECT_GT(d.a.mean, 0.0) << d.name;
    EXPECT_LT(std::abs(d.z()), compared.allowed_z(kChance))
        << d.name << ": stock " << d.a.mean << " +- " << d.a.error << ", ours " << d.b.mean << " +- " << d.b.error;
    // A comparison too blunt to see a difference of a third would prove nothing.
    EXPECT_LT(compared.allowed_z(kChance) * d.relative_error(), 0.33) << d.name;
  }
}

TEST(DemStatistics, MixerCollidesAndHitsItsImpellerAsOftenAndAsHardAsWithStockWalls) {
  const auto scratch = ScratchFolder::make(std::filesystem::temp_directory_path());
  ASSERT_TRUE(scratch);
  const dem::DemCase mixer = measured_for(mixer_case({{0.004, 600}}), 0.05, 3);

  expect_agreement(result_of(compare_walls(mixer, kSeeds, scratch->path(), kLookedAt)));
}

TEST(DemStatistics, BowlCollidesAndHitsItsRotorsAsOftenAndAsHardAsWithStockWalls) {
  const auto scratch = ScratchFolder::make(std::filesystem::temp_directory_path());
  ASSERT_TRUE(scratch);
  const dem::DemCase bowl = measured_for(bowl_case({{0.004, 300}}), 0.05, 2);

  expect_agreement(result_of(compare_walls(bowl, kSeeds, scratch->path(), kLookedAt)));
}

TEST(DemStatistics, SeesThatBouncierParticlesCollideInAnotherWay) {
  const auto scratch = ScratchFolder::make(std::filesystem::temp_directory_path());
  ASSERT_TRUE(scratch);
  const dem::DemCase dull = measured_for(mixer_case({{0.004, 600}}), 0.05, 3);
  dem::DemCase bouncy = dull;
  bouncy.contact.restitution = 0.7;

  const Comparison compared = result_of(compare(dull, bouncy, kSeeds, scratch->path(), kLookedAt));

  EXPECT_GT(std::abs(compared.worst().z()), compared.allowed_z(kChance)) << compared.worst().name;
}

}  // namespace
}  // namespace granary::bench
