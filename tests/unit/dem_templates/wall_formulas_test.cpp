// The formulas of granary/wall that stand alone: wear, contact time, the restart's text.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "dem_templates/plugin/wall/time_step_limits.hpp"
#include "dem_templates/plugin/wall/wall_state.hpp"
#include "dem_templates/plugin/wall/wear.hpp"

namespace granary::dem {
namespace {

using testing::HasSubstr;

TEST(Finnie, IsGreatestForShallowImpactsAndNothingForSquareOnes) {
  const auto at = [](double degrees) { return finnie_volume(1e-11, 2.0, 3.0, 3.0 * std::sin(degrees * M_PI / 180)); };
  EXPECT_NEAR(at(18.4349), at(18.4350), 1e-5 * at(18.4349));  // tan = 1/3: both branches meet
  EXPECT_GT(at(17), at(10));
  EXPECT_GT(at(17), at(30));
  EXPECT_NEAR(at(90), 0.0, 1e-24);
  EXPECT_EQ(at(0), 0.0);
  EXPECT_EQ(at(-20), 0.0);  // it goes away
  EXPECT_NEAR(at(45), 1e-11 * 2.0 * 9.0 * 0.5 / 3.0, 1e-20);
}

TEST(Archard, GoesByTheForceThatPushes) {
  EXPECT_DOUBLE_EQ(archard_volume(1e-13, 20.0, 3.0), 6e-12);
  EXPECT_EQ(archard_volume(1e-13, -20.0, 3.0), 0.0);
}

TEST(WearFile, GivesVolumesAndDepthsOfEachTriangle) {
  Wear wear(2);
  wear.by_sliding = {6e-9, 0.0};
  wear.by_impacts = {0.0, 1e-9};
  const std::string text =
      wear_vtk({{{{0, 0, 0}, {0.02, 0, 0}, {0, 0.03, 0}}}, {{{0, 0, 1}, {0.01, 0, 1}, {0, 0.02, 1}}}}, wear, "wear");
  EXPECT_THAT(text, HasSubstr("POINTS 6 double"));
  EXPECT_THAT(text, HasSubstr("POLYGONS 2 8\n3 0 1 2\n3 3 4 5\n"));
  EXPECT_THAT(text, HasSubstr("volume_by_sliding_m3 double 1\nLOOKUP_TABLE default\n6e-09\n0\n"));
  EXPECT_THAT(text, HasSubstr("depth_by_sliding_m double 1\nLOOKUP_TABLE default\n2e-05\n0\n"));
  EXPECT_THAT(text, HasSubstr("depth_by_impacts_m double 1\nLOOKUP_TABLE default\n0\n1e-05\n"));
}

// Against the motion itself, in small steps.
TEST(HertzContactTime, IsTheTimeOfAnElasticImpact) {
  const double young = 5e6, radius = 0.002, mass = 3e-5, speed = 1.3, step = 1e-9;
  double overlap = 0.0, velocity = speed, time = 0.0;
  do {
    velocity -= step / mass * 4.0 / 3.0 * young * std::sqrt(radius * overlap) * overlap;
    overlap += step * velocity;
    time += step;
  } while (overlap > 0.0);
  EXPECT_NEAR(hertz_contact_time(young, radius, mass, speed), time, 2e-3 * time);
}

std::vector<WallBody> two_bodies() {
  std::vector<WallBody> bodies(2);
  bodies[0].name = "left";
  bodies[0].fingerprint = "abc";
  bodies[1].name = "right";
  bodies[1].fingerprint = "def";
  return bodies;
}

TEST(WallState, ComesBackToTheLastBit) {
  std::vector<WallBody> written = two_bodies(), read = two_bodies();
  written[1].start_angle = 1.0 / 3.0;
  written[1].angle_per_step = -0.1;
  written[1].start_step = 123456789012;
  std::vector<Wear> wear{Wear(0), Wear(2)}, worn{Wear(0), Wear(2)}, none;
  wear[1].by_sliding = {1e-20 / 3, 0.0};
  wear[1].by_impacts = {0.0, 5e-324};

  ASSERT_TRUE(set_wall_state(wall_state(written, wear), read, worn));

  EXPECT_EQ(read[1].start_angle, written[1].start_angle);
  EXPECT_EQ(read[1].angle_per_step, written[1].angle_per_step);
  EXPECT_EQ(read[1].start_step, written[1].start_step);
  EXPECT_EQ(worn[1].by_sliding, wear[1].by_sliding);
  EXPECT_EQ(worn[1].by_impacts, wear[1].by_impacts);
  EXPECT_TRUE(set_wall_state(wall_state(written, wear), read, none));  // who wants none gets none
  EXPECT_TRUE(none.empty());
}

TEST(WallState, OfOtherBodiesChangesNothing) {
  std::vector<WallBody> written = two_bodies(), read = two_bodies();
  std::vector<Wear> none;
  written[0].start_angle = 2.0;
  written[1].fingerprint = "other";

  const Status set = set_wall_state(wall_state(written, none), read, none);

  ASSERT_FALSE(set);
  EXPECT_THAT(set.error().message, HasSubstr("body 'right'"));
  EXPECT_EQ(read[0].start_angle, 0.0);
  EXPECT_FALSE(set_wall_state("", read, none));
}

}  // namespace
}  // namespace granary::dem
