// Touches of a body worked out many at once, against the law touch by touch.
#include "dem_templates/plugin/wall/wall_rows.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace granary::dem {
namespace {

struct Case {
  WallMaterial material;
  WallRows::Touch touch;
  TouchHistory history;
  Vector3 velocity{}, spin{};  // of the particle, in the laboratory
};

std::vector<Case> some_touches(std::size_t n) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> way(-1.0, 1.0), share(0.1, 1.0);
  const auto vector = [&](double size) { return size * Vector3{way(random), way(random), way(random)}; };
  std::vector<Case> cases(n);
  for (Case& c : cases) {
    c.material = {1e7 * share(random), 3e6 * share(random), -0.3 * share(random),
                  0.6 * share(random), 0.1 * share(random), 1e4 * share(random)};
    const double radius = 2e-3 * share(random);
    const Vector3 normal = vector(1.0);
    c.velocity = vector(1.0);
    c.spin = vector(200.0);
    c.history = {vector(3e-6), vector(1e-6)};
    c.touch = {.radius = radius,
               .mass = 4e3 * radius * radius * radius,
               .overlap = 0.05 * radius * share(random),
               .normal = (1.0 / norm(normal)) * normal,
               .point = vector(0.1)};
  }
  return cases;
}

bool agree(const Vector3& a, const Vector3& b) { return norm(a - b) <= 1e-12 * (norm(a) + norm(b)); }

template <RollingModel rolling, bool frozen>
void expect_the_law() {
  constexpr double kStep = 5e-6;
  const WallRows::Frame frame{Turn::about({0.6, 0.0, 0.8}, 1.1), {3.0, 0.0, 4.0}};
  WallRows rows;
  std::size_t sticking = 0, sliding = 0;
  for (const std::size_t n : {WallRows::kMost, std::size_t{0}, std::size_t{1}, std::size_t{13}}) {  // old rows stay
    std::vector<Case> cases = some_touches(n);
    rows.clear();
    for (Case& c : cases) {
      c.touch.velocity = c.velocity.data();
      c.touch.spin = c.spin.data();
      rows.add(c.material, c.touch, c.history);
    }
    rows.advance(frame, rolling, kStep, frozen);
    ASSERT_EQ(rows.size(), n);
    for (std::size_t k = 0; k < n; ++k) {
      const Case& c = cases[k];
      const WallApproach approach{c.touch.radius,
                                  c.touch.mass,
                                  c.touch.overlap,
                                  c.touch.normal,
                                  frame.turn.to_body(c.velocity) - cross(frame.spin, c.touch.point),
                                  frame.turn.to_body(c.spin),
                                  frame.spin};
      TouchHistory history = c.history;
      const WallForce pushed = wall_force<rolling, frozen>(c.material, approach, kStep, history);
      EXPECT_TRUE(agree(rows.force(k), frame.turn.to_lab(pushed.force))) << k;
      EXPECT_TRUE(agree(rows.torque(k), frame.turn.to_lab(pushed.torque))) << k;
      EXPECT_TRUE(agree(rows.history(k).shear, history.shear)) << k;
      EXPECT_TRUE(agree(rows.history(k).rolling_torque, history.rolling_torque)) << k;
      EXPECT_NEAR(rows.normal_force(k), pushed.normal_force, 1e-12 * std::abs(pushed.normal_force));
      EXPECT_NEAR(rows.normal_speed(k), dot(approach.velocity, approach.normal), 1e-12);
      EXPECT_NEAR(rows.speed(k), norm(approach.velocity), 1e-12 * norm(approach.velocity));
      EXPECT_NEAR(rows.slip_speed(k), std::sqrt(pushed.slip2), 1e-12 * std::sqrt(pushed.slip2));
      const Vector3 along = pushed.force - dot(pushed.force, approach.normal) * approach.normal;
      ++(norm(along) < (1.0 - 1e-9) * c.material.friction * std::abs(pushed.normal_force) ? sticking : sliding);
    }
  }
  EXPECT_GT(sticking, 5u);
  EXPECT_GT(sliding, 5u);
}

TEST(WallRows, GiveForEachTouchWhatTheLawGives) {
  expect_the_law<RollingModel::none, false>();
  expect_the_law<RollingModel::cdt, false>();
  expect_the_law<RollingModel::epsd2, false>();
}

TEST(WallRows, LeaveWhatIsRememberedAloneWhenFrozen) {
  expect_the_law<RollingModel::none, true>();
  expect_the_law<RollingModel::cdt, true>();
  expect_the_law<RollingModel::epsd2, true>();
}

}  // namespace
}  // namespace granary::dem
