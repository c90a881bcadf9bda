// The statistics of a few repeats.
#include "common/math/percentile.hpp"

#include <gtest/gtest.h>

namespace granary {
namespace {

TEST(Percentile, LiesBetweenNeighboursByStraightLineInWhateverOrderTheyCame) {
  EXPECT_DOUBLE_EQ(percentile({30.0, 10.0, 20.0}, 0.0), 10.0);
  EXPECT_DOUBLE_EQ(percentile({30.0, 10.0, 20.0}, 0.25), 15.0);
  EXPECT_DOUBLE_EQ(percentile({30.0, 10.0, 20.0}, 1.0), 30.0);
  EXPECT_DOUBLE_EQ(percentile({}, 0.5), 0.0);
}

TEST(Median, IsTheMeanOfTheMiddleTwoOfAnEvenNumber) {
  EXPECT_DOUBLE_EQ(median({4.0, 1.0, 2.0, 9.0}), 3.0);
  EXPECT_DOUBLE_EQ(median({4.0, 1.0, 9.0}), 4.0);
}

}  // namespace
}  // namespace granary
