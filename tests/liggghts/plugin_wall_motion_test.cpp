// granary/wall with bodies that turn, and what it tells of them, with real LIGGGHTS.
#include <algorithm>

#include "tests/liggghts/wall_deck.hpp"

namespace granary::dem::test {
namespace {

TEST(Wall, ThrowsParticlesAsTheStockMovingMeshDoesAtLowSpeed) {
  const Folder folder;
  folder.write("paddle.stl", stl(paddle()));
  const Law law{.gravity = 0.0};
  const double omega = 10.0;
  const std::string period = std::to_string(2 * kPi / omega), end = before_the_paddle() + run(16000, 400);

  const auto mine = frames_of(folder, deck(law) + ours("mesh part paddle.stl rotate part 0 0 0 0 0 1 rad/s 10") + end);
  const auto stock = frames_of(folder, deck(law) + stock_mesh("paddle.stl", law) +
                                           "fix turn all move/mesh mesh part rotate origin 0 0 0 axis 0 0 1 period " +
                                           period + "\n" + end);
  double fastest = 0.0;
  for (const auto& [id, p] : mine.back()) fastest = std::max(fastest, length(p.v));
  EXPECT_GT(fastest, 1.2 * omega * 0.02);
  ASSERT_EQ(mine.size(), stock.size());
  for (const auto& [id, p] : mine.back()) {
    const State& q = stock.back().at(id);
    EXPECT_LT(length({p.v[0] - q.v[0], p.v[1] - q.v[1], p.v[2] - q.v[2]}), 2e-3 * fastest) << id;
  }
}

TEST(Wall, TurnsByTheRightHandAndByPeriodRpmOrRate) {
  std::vector<std::vector<Frame>> found;
  for (const std::string turning : {"rad/s 20", "rpm 190.98593171027440", "period 0.31415926535897931"}) {
    const Folder folder;
    folder.write("paddle.stl", stl(paddle()));
    found.push_back(frames_of(folder, deck({.gravity = 0.0}) +
                                          ours("mesh part paddle.stl rotate part 0 0 0 0 0 1 " + turning) +
                                          particles({{0.03, 0.0032, 0, 0, 0, 0, 0.004}}) + run(2000, 2000)));
  }
  EXPECT_GT(found[0].back().at(1).v[1], 0.5);  // y grows where x turns towards it
  EXPECT_LT(difference(found[0], found[1]), 1e-9);
  EXPECT_LT(difference(found[0], found[2]), 1e-9);
}

TEST(Wall, ReportsForceTorqueAndPowerThatBalanceThoseOnTheParticles) {
  const Folder folder;
  folder.write("paddle.stl", stl(paddle()));
  const double omega = 10.0;
  const Point origin{0.001, -0.002, 0.0};
  const Law law{.models = "rolling_friction epsd2", .gravity = 0.0};
  const auto frames =
      frames_of(folder, deck(law) + before_the_paddle() +
                            ours("mesh part paddle.stl rotate part 0.001 -0.002 0 0 0 1 rad/s 10", law) +
                            print_vector(9) + run(6000, 1));
  const auto values = read_vector(folder);
  int pushed = 0;
  for (std::size_t step = 1; step + 1 < frames.size(); ++step) {
    ASSERT_TRUE(values.contains(static_cast<long>(step)));
    const auto& body = values.at(static_cast<long>(step));
    Point force{}, torque{};
    for (const auto& [id, p] : frames[step]) {
      const Point arm{p.x[0] - origin[0], p.x[1] - origin[1], p.x[2] - origin[2]}, moment = cross(arm, p.force);
      for (std::size_t d = 0; d < 3; ++d) {
        force[d] += p.force[d];
        torque[d] += moment[d] + p.torque[d];
      }
    }
    if (length(force) == 0.0) continue;
    ++pushed;
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_NEAR(body[d], -force[d], 1e-5 * length(force));
      EXPECT_NEAR(body[3 + d], -torque[d], 1e-5 * length(torque));
    }
    EXPECT_NEAR(body[6], omega * torque[2], 1e-5 * omega * length(torque));
  }
  EXPECT_GT(pushed, 20);
}

TEST(Wall, CountsEachImpactOnceWithItsNormalSpeed) {
  const Folder folder;
  folder.write("floor.stl", stl(floor_of(1)));
  const double height = 0.02, speed = std::sqrt(2 * 9.81 * height);
  // One falls onto the seam and bounces three times, one slides over it all the while: it touched from the start.
  const auto frames = frames_of(
      folder, deck({.restitution = 0.9}) + ours("mesh floor floor.stl") +
                  particles({{0, 0, height + 0.002, 0, 0, 0, 0.004}, {0.03, 0.02, 0.001999, 0.1, 0.2, 0, 0.004}}) +
                  print_vector(9) + run(66000, 66000));
  const auto last = read_vector(folder).rbegin()->second;
  EXPECT_EQ(last[7], 3.0);
  EXPECT_NEAR(last[8], (1 + 0.9 + 0.81) * speed, 0.02 * speed);
}

// ---- impacts counted by hand ----

double square(const Point& a) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; }
Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double distance_to_side(const Point& p, const Point& a, const Point& b) {
  const Point ab = minus(b, a), ap = minus(p, a);
  const double t = std::clamp(dot(ap, ab) / dot(ab, ab), 0.0, 1.0);
  return std::sqrt(square({ap[0] - t * ab[0], ap[1] - t * ab[1], ap[2] - t * ab[2]}));
}

/// By the plane above the inside, by the sides elsewhere: not as the code does it. Of triangles farther than `reach`
/// from p it says no more than that.
double distance_by_hand(const Point& p, const std::vector<Corners>& mesh, double reach) {
  double least = 1e300;
  for (const auto& [a, b, c] : mesh) {
    const double size = std::sqrt(std::max(square(minus(b, a)), square(minus(c, a))));
    if (square(minus(p, a)) > (reach + size) * (reach + size)) continue;
    const Point normal = cross(minus(b, a), minus(c, a));
    const bool above = dot(cross(minus(b, a), minus(p, a)), normal) >= 0 &&
                       dot(cross(minus(c, b), minus(p, b)), normal) >= 0 &&
                       dot(cross(minus(a, c), minus(p, c)), normal) >= 0;
    least = std::min({least, distance_to_side(p, a, b), distance_to_side(p, b, c), distance_to_side(p, c, a)});
    if (above) least = std::min(least, std::abs(dot(minus(p, a), normal)) / length(normal));
  }
  return least;
}

/// Times that a particle (radii in order of their numbers) did not touch at a step and touches at the next.
int begins_by_hand(const std::vector<Frame>& frames, const std::vector<Corners>& mesh, double angle_per_step,
                   const std::vector<double>& radii) {
  int begins = 0;
  std::map<int, bool> touched;
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const double angle = -angle_per_step * static_cast<double>(n), c = std::cos(angle), s = std::sin(angle);
    for (const auto& [id, p] : frames[n]) {
      const Point here{c * p.x[0] - s * p.x[1], s * p.x[0] + c * p.x[1], p.x[2]};
      const double radius = radii[static_cast<std::size_t>(id - 1)];
      const bool touches = distance_by_hand(here, mesh, radius) < radius;
      begins += n > 0 && touches && !touched[id];
      touched[id] = touches;
    }
  }
  return begins;
}

/// Two crossed paddles with many coplanar seams in a box that throws particles back into them.
struct Churn {
  std::vector<Corners> mesh = box({-0.04, -0.002, -0.012}, {0.04, 0.002, 0.012}, 6);
  std::vector<double> radii;
  std::string particles_text;

  Churn(double small, double large) {
    const auto across = box({-0.002, -0.04, -0.012}, {0.002, 0.04, 0.012}, 6);
    mesh.insert(mesh.end(), across.begin(), across.end());
    std::vector<TestParticle> list;
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 12; ++k) {
        const double r = 0.012 + 0.0065 * i, angle = kPi / 2 * (k / 3) + kPi / 8 * (k % 3 + 1);
        radii.push_back(k % 2 ? small : large);
        list.push_back({r * std::cos(angle), r * std::sin(angle), 0.003 * (k % 3 - 1), 0, 0, 0.1, 2 * radii.back()});
      }
    }
    particles_text = particles(list);
  }
};

// The stock mesh wall lets go of a particle for some steps where it crosses from one triangle to a coplanar one of a
// mesh that turns, though it overlaps: the tally of such a run counts an impact more than there was.
TEST(Wall, CountsTheImpactsThatACountByHandFindsInThePlacesOfEveryStep) {
  const double rate = 100.0;
  for (const auto& [small, large, time_step] : {std::array{0.0012, 0.0018, 5e-6}, std::array{0.0003, 0.003, 2e-6}}) {
    const Folder folder;
    const Churn churn(small, large);
    folder.write("part.stl", stl(churn.mesh));
    const auto frames =
        frames_of(folder, deck({.restitution = 0.8, .time_step = time_step}) + churn.particles_text +
                              ours("mesh part part.stl rotate part 0 0 0 0 0 1 rad/s 100 cylinder drum 0 0 0 0 0 1 "
                                   "0.045 plane low 0 0 -0.014 0 0 1 plane high 0 0 0.014 0 0 1") +
                              print_vector(9) + run(static_cast<int>(0.01 / time_step), 1));

    const int by_hand = begins_by_hand(frames, churn.mesh, rate * time_step, churn.radii);
    EXPECT_GT(by_hand, 30);
    EXPECT_EQ(read_vector(folder).rbegin()->second[7], by_hand);
  }
}

// ---- a bed in a spinning drum ----

std::vector<Corners> drum(double radius, double half_width, int n) {
  std::vector<Corners> mesh;
  for (int k = 0; k < n; ++k) {
    const double a = 2 * kPi * k / n, b = 2 * kPi * (k + 1) / n;
    const Point u{radius * (std::cos(b) - std::cos(a)), 0, radius * (std::sin(b) - std::sin(a))};
    const auto strip = sheet({radius * std::cos(a), -half_width, radius * std::sin(a)}, {0, 2 * half_width, 0}, u);
    mesh.insert(mesh.end(), strip.begin(), strip.end());
  }
  return mesh;
}

struct Mean {
  double value = 0.0, error = 0.0;
};
/// The error from the scatter of eight blocks.
Mean mean_of_blocks(const std::vector<double>& values) {
  const std::size_t n_blocks = 8, size = values.size() / n_blocks;
  double sum = 0.0, squares = 0.0;
  for (std::size_t b = 0; b < n_blocks; ++b) {
    double block = 0.0;
    for (std::size_t k = 0; k < size; ++k) block += values[b * size + k] / static_cast<double>(size);
    sum += block;
    squares += block * block;
  }
  const auto n = static_cast<double>(n_blocks);
  return {sum / n, std::sqrt(std::max(0.0, squares / n - sum * sum / n / n) / (n - 1))};
}

struct Bed {
  Mean angle, energy;  ///< of its centre from the lowest point [rad]; kinetic, per mass [J/kg]
};
Bed bed_of(const Folder& folder, const std::string& text) {
  std::vector<double> angles, energies;
  const auto frames = frames_of(folder, text);
  for (std::size_t n = frames.size() / 3; n < frames.size(); ++n) {  // the first third starts the bed up
    double x = 0.0, z = 0.0, energy = 0.0;
    for (const auto& [id, p] : frames[n]) {
      x += p.x[0];
      z += p.x[2];
      energy += 0.5 * square(p.v) / static_cast<double>(frames[n].size());
    }
    angles.push_back(std::atan2(x, -z));
    energies.push_back(energy);
  }
  return {mean_of_blocks(angles), mean_of_blocks(energies)};
}

// The bed climbs the side that goes up, as far and as lively as with the stock mesh.
TEST(Wall, CarriesABedUpASpinningDrumAsTheStockMeshDoes) {
  const Folder folder;
  folder.write("drum.stl", stl(drum(0.025, 0.01, 60)));
  std::vector<TestParticle> list;
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3; ++k)
        list.push_back({-0.0130 + 0.00421 * i + 1e-5 * k, -0.0071 + 0.00473 * j, -0.012 + 0.0045 * k, 0, 0, 0, 0.004});
  const Law law{.friction = 0.6};
  const std::string end = particles(list) + run(40000, 50);
  const auto mine = bed_of(folder, deck(law) +
                                       ours("mesh drum drum.stl plane left 0 -0.01 0 0 1 0 plane right 0 0.01 0 0 1 0 "
                                            "rotate drum 0 0 0 0 1 0 rad/s -10",
                                            law) +
                                       end);
  const std::string ends =
      "fix left all wall/gran model hertz tangential history primitive type 2 yplane -0.01\n"
      "fix right all wall/gran model hertz tangential history primitive type 2 yplane 0.01\n";
  const auto stock = bed_of(folder, deck(law) + stock_mesh("drum.stl", law) + ends +
                                        "fix turn all move/mesh mesh part rotate origin 0 0 0 axis 0 -1 0 period " +
                                        std::to_string(2 * kPi / 10) + "\n" + end);
  std::cout << "    angle of the bed [rad]: stock " << stock.angle.value << " +- " << stock.angle.error << ", ours "
            << mine.angle.value << " +- " << mine.angle.error << "\n    kinetic energy [J/kg]: stock "
            << stock.energy.value << " +- " << stock.energy.error << ", ours " << mine.energy.value << " +- "
            << mine.energy.error << "\n";
  EXPECT_GT(mine.angle.value, 0.2);
  EXPECT_LT(std::abs(mine.angle.value - stock.angle.value), 4 * std::hypot(mine.angle.error, stock.angle.error));
  EXPECT_LT(std::abs(mine.energy.value - stock.energy.value), 4 * std::hypot(mine.energy.error, stock.energy.error));
}

}  // namespace
}  // namespace granary::dem::test
