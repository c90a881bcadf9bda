// Pairs of spheres worked out many at once, against the law written down pair by pair.
#include "dem_templates/plugin/pair/pair_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace granary::dem {
namespace {

struct Ball {
  Vector3 place{}, velocity{}, spin{};
  double radius = 0.0, mass = 0.0;
  PairRows::Sphere sphere() const { return {place.data(), velocity.data(), spin.data(), radius, mass}; }
};
struct TouchingPair {
  ContactMaterial material;
  Ball i, j;
  Vector3 shear{}, rolling{};
  std::array<double, 6> history() const { return {shear[0], shear[1], shear[2], rolling[0], rolling[1], rolling[2]}; }
};

std::vector<TouchingPair> some_pairs(std::size_t n) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> way(-1.0, 1.0), share(0.1, 1.0);
  const auto vector = [&](double size) { return size * Vector3{way(random), way(random), way(random)}; };
  std::vector<TouchingPair> all(n);
  for (TouchingPair& t : all) {
    t.material = {1e7 * share(random), 3e6 * share(random), -0.3 * share(random), 0.6 * share(random),
                  0.2 * share(random)};
    for (Ball* ball : {&t.i, &t.j}) {
      ball->radius = 2e-3 * share(random);
      ball->mass = 4e3 * std::pow(ball->radius, 3);
      ball->place = vector(0.1);
      ball->velocity = vector(1.0);
      ball->spin = vector(200.0);
    }
    const Vector3 to = vector(1.0);
    const double overlap = 0.05 * std::min(t.i.radius, t.j.radius) * share(random);
    t.j.place = t.i.place - ((t.i.radius + t.j.radius - overlap) / norm(to)) * to;
    t.shear = vector(1e-5);
    t.rolling = vector(1e-6);
  }
  return all;
}

struct PairPushed {
  Vector3 force_i{}, torque_i{}, torque_j{}, shear{}, rolling{};
  bool slides = false, rolls = false;
  double overlap = 0.0;
};

/// As LIGGGHTS' manual has it, one after the other.
PairPushed pair_by_the_law(const TouchingPair& t, double dt, bool rolling = false) {
  const Vector3 d = t.i.place - t.j.place;
  const double r = norm(d), delta = t.i.radius + t.j.radius - r;
  const Vector3 n = (1.0 / r) * d;
  const double R = 1.0 / (1.0 / t.i.radius + 1.0 / t.j.radius), m = 1.0 / (1.0 / t.i.mass + 1.0 / t.j.mass);
  const double a_i = t.i.radius - delta / 2.0, a_j = t.j.radius - delta / 2.0;
  const Vector3 v = t.i.velocity - t.j.velocity;
  const Vector3 v_t = v - dot(v, n) * n - cross(a_i * t.i.spin + a_j * t.j.spin, n);
  const double S_n = 2.0 * t.material.young * std::sqrt(R * delta), S_t = 8.0 * t.material.shear * std::sqrt(R * delta);
  const double c = 2.0 * std::sqrt(5.0 / 6.0) * t.material.damping;
  const double F_n = 2.0 / 3.0 * S_n * delta + c * std::sqrt(S_n * m) * dot(v, n);

  PairPushed p;
  p.overlap = delta / std::min(t.i.radius, t.j.radius);
  p.shear = t.shear + dt * v_t;
  p.shear = p.shear - dot(p.shear, n) * n;
  Vector3 F_t = -S_t * p.shear;
  const double most = t.material.friction * std::abs(F_n);
  p.slides = norm(F_t) > most;
  if (p.slides) {
    F_t = (most / norm(F_t)) * F_t;
    p.shear = (-1.0 / S_t) * F_t;
  } else {
    F_t = F_t + c * std::sqrt(S_t * m) * v_t;
  }
  p.force_i = F_n * n + F_t;
  p.torque_i = cross(-a_i * n, F_t);
  p.torque_j = cross(a_j * n, -1.0 * F_t);
  if (!rolling) return p;
  const Vector3 w = t.i.spin - t.j.spin;
  p.rolling = t.rolling + dt * S_t * R * R * (w - dot(w, n) * n);
  const double most_torque = t.material.rolling_friction * std::abs(F_n) * R;
  p.rolls = norm(p.rolling) > most_torque;
  if (p.rolls) p.rolling = (most_torque / norm(p.rolling)) * p.rolling;
  p.torque_i = p.torque_i - p.rolling;
  p.torque_j = p.torque_j + p.rolling;
  return p;
}

bool nearly_equal(const Vector3& a, const Vector3& b) { return norm(a - b) <= 1e-11 * (norm(a) + norm(b)); }

void expect_the_law_of_pairs(bool rolling) {
  constexpr double kTimeStep = 5e-6;
  PairRows rows(rolling);
  std::size_t sticking = 0, sliding = 0, resisting = 0, turning = 0;
  for (const std::size_t n : {PairRows::kMost, std::size_t{0}, std::size_t{1}, std::size_t{13}}) {  // old rows stay
    const std::vector<TouchingPair> touches = some_pairs(n);
    rows.clear();
    for (const TouchingPair& t : touches) rows.add(t.material, t.i.sphere(), t.j.sphere(), t.history().data());
    ASSERT_EQ(rows.size(), n);
    ASSERT_EQ(rows.full(), n == PairRows::kMost);
    const double deepest = rows.advance(kTimeStep);
    double expected_deepest = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      const PairPushed p = pair_by_the_law(touches[k], kTimeStep, rolling);
      std::array<double, 6> history{};
      rows.write_history(k, history.data());
      EXPECT_TRUE(nearly_equal(rows.force(k), p.force_i)) << k;
      EXPECT_TRUE(nearly_equal(rows.torque_i(k), p.torque_i)) << k;
      EXPECT_TRUE(nearly_equal(rows.torque_j(k), p.torque_j)) << k;
      EXPECT_TRUE(nearly_equal(vector_of(&history[0]), p.shear)) << k;
      EXPECT_TRUE(nearly_equal(vector_of(&history[3]), p.rolling)) << k;
      expected_deepest = std::max(expected_deepest, p.overlap);
      (p.slides ? sliding : sticking) += 1;
      (p.rolls ? turning : resisting) += 1;
    }
    EXPECT_NEAR(deepest, expected_deepest, 1e-9);
  }
  EXPECT_GT(sticking, 10u);
  EXPECT_GT(sliding, 10u);
  if (rolling) EXPECT_GT(std::min(resisting, turning), 10u);
}

TEST(PairRows, AreTheLawOfEachPair) { expect_the_law_of_pairs(false); }
TEST(PairRows, ResistRolling) { expect_the_law_of_pairs(true); }

TEST(PairRows, TakeNoFrictionAndNoDampingAsTheyAre) {
  std::vector<TouchingPair> touches = some_pairs(9);
  PairRows rows;
  for (TouchingPair& t : touches) {
    t.material.friction = t.material.damping = 0.0;
    rows.add(t.material, t.i.sphere(), t.j.sphere(), t.history().data());
  }
  rows.advance(1e-6);
  for (std::size_t k = 0; k < touches.size(); ++k) {
    const TouchingPair& t = touches[k];
    const Vector3 n = (1.0 / norm(t.i.place - t.j.place)) * (t.i.place - t.j.place);
    EXPECT_TRUE(nearly_equal(rows.force(k), pair_by_the_law(t, 1e-6).force_i));
    EXPECT_TRUE(nearly_equal(rows.force(k), dot(rows.force(k), n) * n));
    std::array<double, 6> history{};
    rows.write_history(k, history.data());
    EXPECT_EQ(norm(rows.torque_i(k)), 0.0);
    EXPECT_EQ(norm(vector_of(&history[0])), 0.0);
  }
}

}  // namespace
}  // namespace granary::dem
