// A list that is made anew only when the frame says so misses no pair.
#include "dem_templates/plugin/lists/turning_frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace granary::dem {
namespace {

constexpr double kSkin = 0.004, kStep = 5e-6;

/// Particles between the axis z and a shell: some turn as fast as the blades, some stand, and all fly about.
struct Bed {
  std::vector<double> places, velocities;

  explicit Bed(double rate, std::size_t n = 120) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0.0, 1.0), way(-3.0, 3.0);
    for (std::size_t i = 0; i < n; ++i) {
      const double r = 0.02 + 0.04 * unit(random), at = 2.0 * M_PI * unit(random);
      const double turning = i % 3 == 0 ? 0.0 : i % 3 == 1 ? 0.5 * rate : rate;
      const std::array<double, 3> x{r * std::cos(at), r * std::sin(at), 0.02 * unit(random)};
      places.insert(places.end(), x.begin(), x.end());
      for (const double v : {-turning * x[1], turning * x[0], 0.0}) velocities.push_back(v + way(random));
    }
  }
  std::size_t n() const { return places.size() / 3; }
  /// On circles with the speed they have, and straight on along the axis.
  void move() {
    for (std::size_t i = 0; i < n(); ++i) {
      double *x = &places[3 * i], *v = &velocities[3 * i];
      const double turn = kStep * (x[0] * v[1] - x[1] * v[0]) / (x[0] * x[0] + x[1] * x[1]);
      const double c = std::cos(turn), s = std::sin(turn);
      for (double* of : {x, v}) {
        const double first = of[0];
        of[0] = c * first - s * of[1];
        of[1] = s * first + c * of[1];
      }
      x[2] += kStep * v[2];
    }
  }
  double distance(std::size_t i, std::size_t j) const {
    return std::hypot(places[3 * i] - places[3 * j], places[3 * i + 1] - places[3 * j + 1],
                      places[3 * i + 2] - places[3 * j + 2]);
  }
};

/// Steps that a list lasts in a frame of that rate. While it does, no two particles come nearer by more than the skin.
int steps_of_a_list(Bed bed, double rate) {
  TurningFrame frame(2);
  frame.start(bed.places.data(), bed.n());
  const Bed then = bed;
  for (int step = 1;; ++step) {
    bed.move();
    if (frame.farthest_moved(bed.places.data(), bed.n(), step * kStep * rate) >= 0.5 * kSkin) return step;
    for (std::size_t i = 0; i < bed.n(); ++i)
      for (std::size_t j = 0; j < i; ++j) EXPECT_GT(bed.distance(i, j), then.distance(i, j) - kSkin);
  }
}

TEST(TurningFrame, IsTrueToAllPairsAtWhateverRateItTurns) {
  for (const double rate : {0.0, 1000.0, 2000.0, -500.0}) EXPECT_GT(steps_of_a_list(Bed(2000.0), rate), 1) << rate;
}

TEST(TurningFrame, LetsAListLastLongerBetweenThoseThatStandAndThoseThatTurn) {
  const Bed bed(2000.0);
  EXPECT_GE(steps_of_a_list(bed, 1000.0), 1.7 * steps_of_a_list(bed, 0.0));
  const auto speeds2 =
      TurningFrame(2).largest_speeds2(bed.places.data(), bed.velocities.data(), bed.n(), std::array{0.0, 1000.0});
  EXPECT_LT(std::sqrt(speeds2[1]), 0.6 * std::sqrt(speeds2[0]));
}

TEST(TurningFrame, HasMovedBeyondAllWhereParticlesAreOthersOrNoNumbers) {
  Bed bed(0.0);
  TurningFrame frame(0);
  frame.start(bed.places.data(), bed.n());
  EXPECT_EQ(frame.farthest_moved(bed.places.data(), bed.n(), 0.0), 0.0);
  EXPECT_TRUE(std::isinf(frame.farthest_moved(bed.places.data(), bed.n() - 1, 0.0)));
  bed.places[10] += 3e-3;
  EXPECT_DOUBLE_EQ(frame.farthest_moved(bed.places.data(), bed.n(), 0.0), 3e-3);
  bed.places[7] = std::nan("");
  EXPECT_TRUE(std::isinf(frame.farthest_moved(bed.places.data(), bed.n(), 0.0)));
}

}  // namespace
}  // namespace granary::dem
