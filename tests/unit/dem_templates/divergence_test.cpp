// When a DEM run has diverged, and that it says why.
#include "dem_templates/plugin/guard/divergence.hpp"

#include <gtest/gtest.h>

namespace granary::dem {
namespace {

const Bounds kBounds{.overlap = 0.2, .overlapping_fraction = 0.01, .energy = 1.0, .lost_fraction = 0.02};

const Vitals kOverlapping{.overlap = 0.41, .overlapping = 12, .present = 300};

TEST(Divergence, IsNoneWithinTheBounds) {
  EXPECT_FALSE(find_divergence(
      {.overlap = 0.7, .overlapping = 3, .present = 300, .energy = 0.9, .lost = 2, .ever_present = 100}, kBounds));
  EXPECT_FALSE(find_divergence({.overlap = 0.7, .overlapping = 1, .present = 5}, kBounds));  // pinched by a blade
  EXPECT_FALSE(find_divergence({.energy = 1e9}, Bounds{}));  // no energy bound was asked for
  EXPECT_FALSE(find_divergence({.lost = -3, .ever_present = 0}, kBounds));
}

TEST(Divergence, NamesItsCauseValueBoundAndSettings) {
  const auto overlap = find_divergence(kOverlapping, kBounds);
  ASSERT_TRUE(overlap);
  EXPECT_EQ(overlap->cause, "overlap");
  EXPECT_EQ(overlap->value, 0.04);
  EXPECT_EQ(overlap->bound, 0.01);
  EXPECT_NE(overlap->message.find("12 of 300"), std::string::npos);
  EXPECT_NE(overlap->message.find("0.41"), std::string::npos);
  EXPECT_NE(overlap->message.find("time step"), std::string::npos);
  EXPECT_EQ(overlap->settings.at(0), "/dem/time_step");

  EXPECT_EQ(find_divergence({.energy = 2.0}, kBounds)->cause, "energy");
  EXPECT_EQ(find_divergence({.lost = 3, .ever_present = 100}, kBounds)->cause, "lost");
  EXPECT_EQ(find_divergence({.finite = false, .overlapping = 12, .present = 300}, kBounds)->cause, "nan");
}

TEST(Divergence, BecomesTheLastLineOfTheTallies) {
  const auto line = divergence_line(*find_divergence(kOverlapping, kBounds), 0.071);
  const auto& diverged = line["diverged"];
  EXPECT_EQ(diverged.text_or("cause", ""), "overlap");
  EXPECT_EQ(diverged.number_or("time_s", 0), 0.071);
  EXPECT_EQ(diverged.number_or("bound", 0), 0.01);
  EXPECT_GE(diverged["settings"].size(), 2u);
}

}  // namespace
}  // namespace granary::dem
