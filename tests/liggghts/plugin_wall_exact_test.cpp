// granary/wall against exact results, with LIGGGHTS' own walls beside it where they have the case, with real LIGGGHTS.
// The figures it prints stand in docs/dem_verification.md.
#include <algorithm>

#include "tests/liggghts/wall_deck.hpp"

namespace granary::dem::test {
namespace {

/// Says a figure of the table: what, expected, got.
void say(const std::string& what, double expected, double got) {
  std::cout << "    " << what << ": expected " << expected << ", got " << got << "\n";
}

// ---- impacts ----

const std::vector<double> kSpeeds{0.2, 1.0, 5.0}, kAngles{0, 10, 20, 30, 40, 50, 60, 70, 80};  // m/s, degrees

struct Fall {
  double normal, along;  ///< speeds [m/s]
};
std::vector<Fall> all_falls() {
  std::vector<Fall> falls;
  for (const double speed : kSpeeds)
    for (const double angle : kAngles)
      falls.push_back({speed * std::cos(angle * kPi / 180), speed * std::sin(angle * kPi / 180)});
  return falls;
}
/// On the plane z = 0, each on a path of its own.
std::string falling_particles() {
  std::vector<TestParticle> list;
  for (const Fall& fall : all_falls()) {
    const auto k = static_cast<double>(list.size());
    list.push_back({-0.03 + 0.001 * k, -0.054 + 0.0041 * k, kRadius + 2e-5, fall.along, 0, -fall.normal, 2 * kRadius});
  }
  return particles(list);
}

// Rebound at every speed and angle as the stock plane has it; and as rigid-body mechanics has it (Johnson, Contact
// Mechanics, 11.6; Foerster et al., Phys. Fluids 6, 1994): the normal speed times e; while it slides all through, the
// tangential speed less mu (1 + e) v_n; and always the angular momentum about the point of impact kept.
TEST(WallExact, ReboundsAtEverySpeedAndAngle) {
  double worst_normal = 0.0, worst_spin = 0.0, worst_stock = 0.0;
  std::map<double, double> worst_sliding;  // by restitution
  int sliding = 0, sticking = 0;
  for (const double restitution : {0.3, 0.6, 0.9}) {
    const Folder folder;
    const Law law{.restitution = restitution, .friction = 0.3, .gravity = 0.0};
    const std::string end = falling_particles() + run(1500, 1500);
    const auto mine = frames_of(folder, deck(law) + ours("plane floor 0 0 0 0 0 1") + end);
    const auto stock = frames_of(folder, deck(law) + stock_plane(law) + end);
    worst_stock = std::max(worst_stock, difference(mine, stock));

    int id = 0;
    for (const auto& [normal, along] : all_falls()) {
      const State& after = mine.back().at(++id);
      if (after.x[2] < kRadius) continue;  // still in touch
      worst_normal = std::max(worst_normal, std::abs(after.v[2] / normal - restitution));
      const double slid = law.friction * (normal + after.v[2]), lost = along - after.v[0];
      if (along > 3.5 * slid * 1.3) {  // slips to the end (3.5 = 7/2), by a margin for Mindlin's spring
        ++sliding;
        double& worst = worst_sliding[restitution];
        worst = std::max(worst, std::abs(lost / slid - 1.0));
      } else if (along > 0.0 && along < 2.0 * slid) {
        ++sticking;
        EXPECT_LT(lost, slid);
      }
      if (along > 0.0) worst_spin = std::max(worst_spin, std::abs(kRadius * after.spin[1] / (2.5 * lost) - 1.0));
      EXPECT_LE(length(after.v), std::hypot(normal, along));
    }
  }
  say("normal restitution, largest error", 0.0, worst_normal);
  for (const auto& [restitution, worst] : worst_sliding)
    say("sliding impact, relative error of the tangential impulse at e = " + std::to_string(restitution), 0.0, worst);
  say("spin from the tangential impulse, relative error", 0.0, worst_spin);
  say("difference to the stock plane", 0.0, worst_stock);
  EXPECT_LT(worst_normal, 0.02);
  // The dashpot pulls at the end of a contact; Coulomb's limit goes by the size of the force, and so counts the pull
  // as a push: little at e = 0.9, a third of the impulse and more at 0.3. The stock wall does the same.
  EXPECT_LT(worst_sliding[0.9], 0.02);
  EXPECT_LT(worst_spin, 0.1);  // the arm is shorter by half the overlap: 8 % of the radius at 5 m/s
  EXPECT_LT(worst_stock, 1e-11);
  EXPECT_GT(sliding, 10);
  EXPECT_GT(sticking, 10);
}

// ---- rolling and sliding ----

/// A disc of triangles, tilted about y by `slope`: its point (x, y) and its normal.
struct Slope {
  double angle;
  Point at(double x, double y, double height = 0.0) const {
    return {x * std::cos(angle) + height * std::sin(angle), y, -x * std::sin(angle) + height * std::cos(angle)};
  }
  std::vector<Corners> mesh() const {
    const Point corner = at(-0.05, -0.05), u = at(0.1, 0), v{0, 0.1, 0};
    return sheet(corner, u, v, 15);
  }
  double along(const Point& v) const { return v[0] * std::cos(angle) - v[2] * std::sin(angle); }
};

/// Overlap at which the spring carries the weight.
double resting_overlap(double weight) {
  return std::cbrt(std::pow(weight / (4.0 / 3.0 * effective_young() * std::sqrt(kRadius)), 2));
}

State after_a_while_on(const Slope& slope, double friction, const std::string& rotation, int steps, double x0,
                       bool stock = false) {
  const Folder folder;
  folder.write("slope.stl", stl(slope.mesh()));
  const Law law{.friction = friction};
  const double overlap = resting_overlap(kMass * law.gravity * std::cos(slope.angle));
  const Point start = slope.at(x0, 0.0, kRadius - overlap);
  const std::string walls = stock ? stock_mesh("slope.stl", law) : ours("mesh slope slope.stl " + rotation, law);
  return frames_of(folder, deck(law) + walls + particles({{start[0], start[1], start[2], 0, 0, 0, 2 * kRadius}}) +
                               run(steps, steps))
      .back()
      .at(1);
}

// Rolling: a = 5/7 g sin; sliding: a = g (sin - mu cos), spin = 5/2 mu g cos t / R. Over the seams of 450 triangles.
TEST(WallExact, RollsAndSlidesDownASlopeOfManyTriangles) {
  const Slope slope{20 * kPi / 180};
  const int steps = 16000;
  const double time = steps * kTimeStep, g = 9.81, sine = std::sin(slope.angle), cosine = std::cos(slope.angle);

  const State rolls = after_a_while_on(slope, 0.5, "", steps, -0.02);
  say("rolling down 20 degrees, speed", 5.0 / 7.0 * g * sine * time, slope.along(rolls.v));
  EXPECT_NEAR(slope.along(rolls.v), 5.0 / 7.0 * g * sine * time, 0.005 * slope.along(rolls.v));
  EXPECT_NEAR(rolls.spin[1] * kRadius, slope.along(rolls.v), 0.005 * slope.along(rolls.v));

  const State slides = after_a_while_on(slope, 0.08, "", steps, -0.02);
  const double speed = g * (sine - 0.08 * cosine) * time, spin = 2.5 * 0.08 * g * cosine * time / kRadius;
  say("sliding down 20 degrees, speed", speed, slope.along(slides.v));
  say("sliding down 20 degrees, spin", spin, slides.spin[1]);
  EXPECT_NEAR(slope.along(slides.v), speed, 0.005 * speed);
  EXPECT_NEAR(slides.spin[1], spin, 0.005 * spin);

  const State stock = after_a_while_on(slope, 0.5, "", steps, -0.02, true);
  say("rolling down 20 degrees, speed with the stock mesh", slope.along(rolls.v), slope.along(stock.v));
}

// A sphere that rolls on a turning, tilted disc (Earnshaw, Dynamics, 1844; Weckesser, Am. J. Phys. 65, 1997):
// dv/dt = 2/7 Omega n x v + 5/7 g sin; from rest at the axis, with w = 2/7 Omega and a = 5/7 g sin:
// v = a / w (sin wt, 1 - cos wt), so that it runs across the slope and not down it.
TEST(WallExact, RollsAcrossAnInclinedTurningMesh) {
  const Slope slope{15 * kPi / 180};
  const double rate = 60.0, w = 2.0 / 7.0 * rate, a = 5.0 / 7.0 * 9.81 * std::sin(slope.angle);
  const int steps = 24000;
  const double time = steps * kTimeStep;
  const Point normal = slope.at(0, 0, 1);
  std::ostringstream rotation;
  rotation.precision(17);
  rotation << "rotate slope 0 0 0 " << normal[0] << " " << normal[1] << " " << normal[2] << " rad/s " << rate;

  const State end = after_a_while_on(slope, 0.9, rotation.str(), steps, 0.0);

  const double down = a / w * std::sin(w * time), across = a / w * (1 - std::cos(w * time));
  const double way_down = a / (w * w) * (1 - std::cos(w * time)), way_across = a / w * (time - std::sin(w * time) / w);
  say("speed down a turning slope", down, slope.along(end.v));
  say("speed across it", across, end.v[1]);
  say("way across it", way_across, end.x[1]);
  const double fastest = 2 * a / w;
  EXPECT_NEAR(slope.along(end.v), down, 0.01 * fastest);
  EXPECT_NEAR(end.v[1], across, 0.01 * fastest);
  EXPECT_NEAR(slope.along(end.x), way_down, 0.01 * way_across);
  EXPECT_NEAR(end.x[1], way_across, 0.01 * way_across);
}

// ---- energy ----

struct Work {
  double by_wall = 0.0, kinetic = 0.0;
};
/// A paddle, its broad side at 45 mm from the axis, meets a particle at rest head-on.
Work of_one_blow(double restitution, double friction, double time_step, double height) {
  const Folder folder;
  folder.write("paddle.stl", stl(paddle()));
  const Law law{.restitution = restitution, .friction = friction, .gravity = 0.0, .time_step = time_step};
  const int steps = static_cast<int>(std::lround(0.003 / time_step));
  const auto frames = frames_of(folder, deck(law) + ours("mesh part paddle.stl rotate part 0 0 0 0 0 1 rad/s 30", law) +
                                            particles({{0.045, 0.001 + kRadius + 2e-5, height, 0, 0, 0, 2 * kRadius}}) +
                                            print_vector(9) + run(steps, steps));
  const State& end = frames.back().at(1);
  Work work;
  for (const auto& [step, values] : read_vector(folder)) work.by_wall += values[6] * time_step;
  const double v = length(end.v), spin = length(end.spin);
  work.kinetic = 0.5 * kMass * v * v + 0.5 * 0.4 * kMass * kRadius * kRadius * spin * spin;
  EXPECT_GT(v, 1.0);
  return work;
}

// Work of the wall = kinetic energy + what was dissipated. Nothing is with e = 1 and no friction, up to the
// integrator's order; and (1 - e^2) m v^2 / 2 in a blow with e, v the wall's speed there.
TEST(WallExact, KeepsTheEnergyThatTheWallsGive) {
  const Work coarse = of_one_blow(1.0, 0.0, 1e-5, 0.0), fine = of_one_blow(1.0, 0.0, 2.5e-6, 0.0);
  const double error_coarse = std::abs(coarse.by_wall / coarse.kinetic - 1.0);
  const double error_fine = std::abs(fine.by_wall / fine.kinetic - 1.0);
  say("elastic blow, relative energy error at 10 us", 0.0, error_coarse);
  say("elastic blow, relative energy error at 2.5 us", 0.0, error_fine);
  EXPECT_LT(error_coarse, 2e-3);
  EXPECT_LT(error_fine, error_coarse / 8);

  const double e = 0.5, speed = 30.0 * 0.045;
  const Work lossy = of_one_blow(e, 0.0, 2.5e-6, 0.0);
  const double lost = 0.5 * kMass * (1 - e * e) * speed * speed;
  say("blow with e = 0.5, dissipated [J]", lost, lossy.by_wall - lossy.kinetic);
  EXPECT_NEAR(lossy.by_wall - lossy.kinetic, lost, 0.03 * lost);
}

}  // namespace
}  // namespace granary::dem::test
