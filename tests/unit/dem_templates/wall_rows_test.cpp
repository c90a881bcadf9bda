// Touches of a body worked out many at once, against the law touch by touch.
#include "dem_templates/plugin/wall/wall_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace granary::dem {
namespace {

struct Case {
  ContactMaterial material;
  double radius = 0.0, mass = 0.0, overlap = 0.0;
  Vector3 normal{}, point{};
  Vector3 velocity{}, spin{};  // of the particle, in the laboratory
  TouchHistory history;

  WallRows::Touch touch() const {
    return {radius,
            mass,
            overlap,
            normal.data(),
            point.data(),
            velocity.data(),
            spin.data(),
            history.shear.data(),
            history.rolling_torque.data()};
  }
};

std::vector<Case> some_touches(std::size_t n) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> way(-1.0, 1.0), share(0.1, 1.0);
  const auto vector = [&](double size) { return size * Vector3{way(random), way(random), way(random)}; };
  std::vector<Case> cases(n);
  for (Case& c : cases) {
    c.material = {1e7 * share(random), 3e6 * share(random), -0.3 * share(random),
                  0.6 * share(random), 0.1 * share(random), 1e4 * share(random)};
    const Vector3 normal = vector(1.0);
    c.radius = 2e-3 * share(random);
    c.mass = 4e3 * c.radius * c.radius * c.radius;
    c.overlap = 0.05 * c.radius * share(random);
    c.normal = (1.0 / norm(normal)) * normal;
    c.point = vector(0.1);
    c.velocity = vector(1.0);
    c.spin = vector(200.0);
    c.history = {vector(3e-6), vector(1e-6)};
  }
  return cases;
}

bool agree(const Vector3& a, const Vector3& b) { return norm(a - b) <= 1e-12 * (norm(a) + norm(b)); }

template <RollingModel rolling, bool frozen>
void expect_the_law() {
  constexpr double kTimeStep = 5e-6;
  const WallRows::Frame frame{Turn::about({0.6, 0.0, 0.8}, 1.1), {3.0, 0.0, 4.0}, {0.02, -0.01, 0.03}};
  WallRows rows(rolling);
  std::size_t sticking = 0, sliding = 0;
  for (const std::size_t n : {WallRows::kMost, std::size_t{0}, std::size_t{1}, std::size_t{13}}) {  // old rows stay
    const std::vector<Case> cases = some_touches(n);
    rows.clear();
    for (const Case& c : cases) rows.add(c.material, c.touch());
    const WallRows::Sums sums = rows.advance(frame, kTimeStep, frozen);
    ASSERT_EQ(rows.size(), n);
    Vector3 force{}, moment{};
    double deepest = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const Case& c = cases[k];
      const WallApproach approach{c.radius,
                                  c.mass,
                                  c.overlap,
                                  c.normal,
                                  frame.turn.to_body(c.velocity) - cross(frame.spin, c.point - frame.origin),
                                  frame.turn.to_body(c.spin),
                                  frame.spin};
      TouchHistory history = c.history;
      if (rolling != RollingModel::epsd2) history.rolling_torque = {};
      const WallForce pushed = wall_force<rolling, frozen>(c.material, approach, kTimeStep, history);
      EXPECT_TRUE(agree(rows.force(k), frame.turn.to_lab(pushed.force))) << k;
      EXPECT_TRUE(agree(rows.torque(k), frame.turn.to_lab(pushed.torque))) << k;
      EXPECT_TRUE(agree(rows.shear(k), history.shear)) << k;
      EXPECT_TRUE(agree(rows.rolling_torque(k), history.rolling_torque)) << k;
      EXPECT_NEAR(rows.normal_force(k), pushed.normal_force, 1e-12 * std::abs(pushed.normal_force));
      EXPECT_NEAR(rows.normal_speed(k), dot(approach.velocity, approach.normal), 1e-12);
      EXPECT_NEAR(rows.speed(k), norm(approach.velocity), 1e-12 * norm(approach.velocity));
      EXPECT_NEAR(rows.slip_speed(k), std::sqrt(pushed.slip2), 1e-12 * std::sqrt(pushed.slip2));
      const Vector3 along = pushed.force - dot(pushed.force, approach.normal) * approach.normal;
      const Vector3 centre = c.point + (c.radius - c.overlap) * c.normal - frame.origin;
      force = force + frame.turn.to_lab(pushed.force);
      moment = moment + frame.turn.to_lab(cross(centre, pushed.force) + pushed.torque);
      deepest = std::max(deepest, c.overlap / c.radius);
      ++(norm(along) < (1.0 - 1e-9) * c.material.friction * std::abs(pushed.normal_force) ? sticking : sliding);
    }
    EXPECT_LE(norm(sums.force - force), 1e-12 * norm(force));
    EXPECT_LE(norm(sums.moment - moment), 1e-12 * norm(moment));
    EXPECT_EQ(sums.deepest, deepest);
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

// What is worked out for no touch, to fill a vector, must not grow from step to step until it is no number.
TEST(WallRows, SumOnlyWhatTouchesHoweverLong) {
  WallRows rows(RollingModel::epsd2);
  const std::vector<Case> one = some_touches(1);
  const auto advance = [&] {
    rows.clear();
    rows.add(one[0].material, one[0].touch());
    return rows.advance({Turn{}, {0.0, 0.0, 200.0}, {}}, 5e-6, false);
  };
  const WallRows::Sums first = advance();
  for (int step = 0; step < 5000; ++step) advance();
  const WallRows::Sums last = advance();
  EXPECT_EQ(last.force, first.force);
  EXPECT_EQ(last.moment, first.moment);
}

}  // namespace
}  // namespace granary::dem
