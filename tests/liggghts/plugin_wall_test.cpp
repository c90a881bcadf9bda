// granary/wall against LIGGGHTS' own walls, and against forces worked out by hand, with real LIGGGHTS.
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "tests/liggghts/plugin_deck.hpp"

namespace granary::dem::test {
namespace {

using Point = std::array<double, 3>;
using Corners = std::array<Point, 3>;

constexpr double kPi = std::numbers::pi;

double length(const Point& a) { return std::hypot(a[0], a[1], a[2]); }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// ---- meshes ----

std::string stl(const std::vector<Corners>& triangles) {
  std::ostringstream text;
  text.precision(17);
  text << "solid part\n";
  for (const Corners& triangle : triangles) {
    text << "facet normal 0 0 0\n outer loop\n";
    for (const auto& c : triangle) text << "  vertex " << c[0] << " " << c[1] << " " << c[2] << "\n";
    text << " endloop\nendfacet\n";
  }
  return text.str() + "endsolid part\n";
}

/// The parallelogram from `corner` along u and v in n x n pairs of triangles, their diagonals in turns.
std::vector<Corners> sheet(const Point& corner, const Point& u, const Point& v, int n = 1) {
  const auto at = [&](int i, int j) {
    Point p{};
    for (std::size_t d = 0; d < 3; ++d) p[d] = corner[d] + (u[d] * i + v[d] * j) / n;
    return p;
  };
  std::vector<Corners> triangles;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const Point a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      const bool falls = (i + j) % 2 == 0;
      triangles.push_back(falls ? Corners{a, b, c} : Corners{a, b, d});
      triangles.push_back(falls ? Corners{a, c, d} : Corners{b, c, d});
    }
  }
  return triangles;
}

/// A closed box, its faces turned outwards.
std::vector<Corners> box(const Point& low, const Point& high, int n = 1) {
  const Point x{high[0] - low[0], 0, 0}, y{0, high[1] - low[1], 0}, z{0, 0, high[2] - low[2]};
  std::vector<Corners> all;
  for (const auto& face :
       {sheet(low, y, x, n), sheet(low, x, z, n), sheet(low, z, y, n), sheet({low[0], low[1], high[2]}, x, y, n),
        sheet({low[0], high[1], low[2]}, z, x, n), sheet({high[0], low[1], low[2]}, y, z, n)})
    all.insert(all.end(), face.begin(), face.end());
  return all;
}

std::vector<Corners> floor_of(int n) { return sheet({-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}, n); }

// ---- decks ----

struct Law {
  std::string models;  ///< after "tangential history"
  double restitution = 0.5, friction = 0.4;
  double gravity = 9.81;
  std::string more;  ///< commands before the box's contents, e.g. processors
};

constexpr double kYoung = 5e6, kWallYoung = 5e8, kPoisson = 0.3, kTimeStep = 5e-6;

/// Type 1: particles, type 2: walls. `state`: a box, or the name of a restart file.
std::string deck(const Law& law, const std::string& state = "-0.06 0.06 -0.06 0.06 -0.03 0.06") {
  std::ostringstream text;
  text << "atom_style granular\natom_modify map array\nboundary f f f\nnewton off\ncommunicate single vel yes\n"
       << "units si\n"
       << law.more
       << (state.find(' ') == std::string::npos ? "read_restart " + state + "\n"
                                                : "region box block " + state + " units box\ncreate_box 2 box\n")
       << "neighbor 0.001 bin\nneigh_modify delay 0\n"
       << "fix m1 all property/global youngsModulus peratomtype " << kYoung << " " << kWallYoung << "\n"
       << "fix m2 all property/global poissonsRatio peratomtype " << kPoisson << " " << kPoisson << "\n";
  const auto pairs = [&](const char* name, const char* property, double value) {
    text << "fix " << name << " all property/global " << property << " peratomtypepair 2";
    for (int k = 0; k < 4; ++k) text << " " << value;
    text << "\n";
  };
  pairs("m3", "coefficientRestitution", law.restitution);
  pairs("m4", "coefficientFriction", law.friction);
  pairs("m5", "coefficientRollingFriction", 0.1);
  pairs("m6", "cohesionEnergyDensity", 3e3);
  text << "pair_style gran model hertz tangential history " << law.models << "\npair_coeff * *\n"
       << "timestep " << kTimeStep << "\nfix integrate all nve/sphere\n"
       << "fix g all gravity " << law.gravity << " vector 0 0 -1\n"
       << "thermo 100000\nthermo_modify lost ignore norm no\n";
  return text.str();
}

std::string ours(const std::string& bodies, const Law& law = {}) {
  return "fix walls all granary/wall type 2 " + bodies + " " + law.models + "\n";
}
std::string stock_plane(const Law& law) {
  return "fix walls all wall/gran model hertz tangential history " + law.models + " primitive type 2 zplane 0.0\n";
}
std::string stock_mesh(const std::string& file, const Law& law) {
  return "fix part all mesh/surface file " + file + " type 2\nfix walls all wall/gran model hertz tangential history " +
         law.models + " mesh n_meshes 1 meshes part\n";
}

/// Runs and keeps x v omega f torque of all particles every so many steps.
std::string run(int steps, int every) {
  return "dump d all custom " + std::to_string(every) +
         " dump.txt id x y z vx vy vz omegax omegay omegaz fx fy fz tqx tqy tqz\ndump_modify d sort id format \"%d" +
         [] {
           std::string format;
           for (int k = 0; k < 15; ++k) format += " %.17g";
           return format;
         }() +
         "\"\nrun " + std::to_string(steps) + "\n";
}

struct State {
  Point x{}, v{}, spin{}, force{}, torque{};
};
using Frame = std::map<int, State>;

std::vector<Frame> read_dump(const Folder& folder) {
  std::istringstream in(folder.read("dump.txt"));
  std::vector<Frame> frames;
  bool rows = false;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("ITEM: ", 0) == 0) {
      rows = line.rfind("ITEM: ATOMS", 0) == 0;
      if (rows) frames.emplace_back();
      continue;
    }
    if (!rows) continue;
    std::istringstream words(line);
    int id = 0;
    State s;
    words >> id;
    for (Point* p : {&s.x, &s.v, &s.spin, &s.force, &s.torque})
      for (double& value : *p) words >> value;
    frames.back()[id] = s;
  }
  return frames;
}

std::vector<Frame> frames_of(const Folder& folder, const std::string& text, int ranks = 1) {
  EXPECT_EQ(run_deck(folder, text, ranks), 0) << folder.read("err");
  return read_dump(folder);
}

/// Largest difference of places [m], velocities [m/s] and spins over 1000/s, over all frames.
double difference(const std::vector<Frame>& a, const std::vector<Frame>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0.0;
  for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n) {
    EXPECT_EQ(a[n].size(), b[n].size());
    for (const auto& [id, p] : a[n]) {
      if (!b[n].contains(id)) continue;
      const State& q = b[n].at(id);
      for (std::size_t d = 0; d < 3; ++d)
        largest = std::max(
            {largest, std::abs(p.x[d] - q.x[d]), std::abs(p.v[d] - q.v[d]), 1e-3 * std::abs(p.spin[d] - q.spin[d])});
    }
  }
  return largest;
}

/// fix_print of the fix's vector at every step: values.txt.
std::string print_vector(int n) {
  std::string variables, text;
  for (int k = 1; k <= n; ++k) {
    variables += "variable s" + std::to_string(k) + " equal f_walls[" + std::to_string(k) + "]\n";
    text += " ${s" + std::to_string(k) + "}";
  }
  return variables + "variable now equal step\nfix print all print 1 \"${now}" + text +
         "\" file values.txt screen no\n";
}
std::map<long, std::vector<double>> read_vector(const Folder& folder) {
  std::istringstream in(folder.read("values.txt"));
  std::map<long, std::vector<double>> found;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    long step = 0;
    if (!(words >> step)) continue;
    double value = 0.0;
    while (words >> value) found[step].push_back(value);
  }
  return found;
}

double effective_young() { return 1.0 / ((1 - kPoisson * kPoisson) / kYoung + (1 - kPoisson * kPoisson) / kWallYoung); }
double hertz(double radius, double overlap) {
  return 4.0 / 3.0 * effective_young() * std::sqrt(radius * overlap) * overlap;
}

// ---- the contact law ----

// A normal and two oblique impacts, one with a bounce on it, and a slow slide: sticking, slipping, rolling.
std::string falling() {
  return particles({{-0.02, 0.013, 0.0025, 0, 0, -1, 0.004},
                    {-0.02, -0.013, 0.0025, 0.5, 0.3, -1, 0.004},
                    {0.01, -0.01, 0.0025, -0.5, 0.8, -2, 0.003},
                    {0.02, -0.021, 0.0019, -0.3, 0, 0, 0.004}});
}

TEST(Wall, PushesAsTheStockPlaneAndTheStockMeshWithEveryModel) {
  for (const std::string rolling : {"", " rolling_friction epsd2", " rolling_friction cdt"}) {
    for (const std::string cohesion : {"", "cohesion sjkr"}) {
      const Folder folder;
      folder.write("floor.stl", stl(floor_of(1)));
      const Law law{.models = cohesion + rolling};
      const std::string end = falling() + run(6000, 20);

      const auto mine = frames_of(folder, deck(law) + ours("mesh floor floor.stl", law) + end);
      const auto plane = frames_of(folder, deck(law) + stock_plane(law) + end);
      const auto mesh = frames_of(folder, deck(law) + stock_mesh("floor.stl", law) + end);

      EXPECT_LT(difference(mine, plane), 1e-11) << law.models;
      EXPECT_LT(difference(mine, mesh), 1e-11) << law.models;
      EXPECT_GT(std::abs(mine.back().at(2).spin[1]), 1.0);
    }
  }
}

TEST(Wall, GivesBackTheStatedShareOfTheNormalSpeed) {
  for (const double restitution : {0.3, 0.6, 0.9}) {
    for (const double speed : {0.1, 1.0, 5.0}) {
      const Folder folder;
      const Law law{.restitution = restitution, .gravity = 0.0};
      const auto frames = frames_of(folder, deck(law) + ours("plane floor 0 0 0 0 0 1") +
                                                particles({{0, 0, 0.0021, 0, 0, -speed, 0.004}}) + run(1500, 1500));
      EXPECT_NEAR(frames.back().at(1).v[2], restitution * speed, 0.02 * speed) << restitution << " at " << speed;
    }
  }
}

// Sliding impact: the tangential impulse is mu (1 + e) m v_n (Johnson, Contact Mechanics, 11.6 (b)).
TEST(Wall, ChangesTheTangentialSpeedOfASlidingImpactByCoulombsShare) {
  const Folder folder;
  const double normal = 1.0, along = 20.0, friction = 0.3;
  const Law law{.restitution = 0.8, .friction = friction, .gravity = 0.0};
  const auto frames = frames_of(folder, deck(law) + ours("plane floor 0 0 0 0 0 1") +
                                            particles({{-0.03, 0, 0.0021, along, 0, -normal, 0.004}}) + run(500, 500));
  const State& after = frames.back().at(1);
  const double lost = along - after.v[0];
  EXPECT_NEAR(lost, friction * (normal + after.v[2]), 0.02 * lost);
  EXPECT_NEAR(after.spin[1], 2.5 * lost / 0.002, 0.06 * after.spin[1]);
}

// ---- one push per patch ----

TEST(Wall, LetsAParticleSlideAndRollOverSeamsWithoutABump) {
  const Folder folder;
  folder.write("two.stl", stl(floor_of(1)));
  folder.write("many.stl", stl(floor_of(40)));
  const Law law{.models = "rolling_friction epsd2"};
  const std::string end = particles({{-0.03, -0.03, 0.001999, 0.8, 0.5, 0, 0.004},
                                     {-0.03, 0.0, 0.001999, 0.9, 0, 0, 0.004},
                                     {0.01, 0.0101, 0.001999, 0, -0.6, 0, 0.004}}) +
                          run(8000, 10);

  const auto plane = frames_of(folder, deck(law) + ours("plane floor 0 0 0 0 0 1", law) + end);
  const auto two = frames_of(folder, deck(law) + ours("mesh floor two.stl", law) + end);
  const auto many = frames_of(folder, deck(law) + ours("mesh floor many.stl", law) + end);

  EXPECT_LT(difference(two, plane), 1e-10);
  EXPECT_LT(difference(many, plane), 1e-10);
  EXPECT_GT(plane.back().at(1).x[0], -0.01);  // it did travel: over eight seams of the fine floor and more
}

/// Force on a sphere of radius 2 mm that rests at `place` beside the mesh, at the first step.
Point force_at(const std::vector<Corners>& mesh, const Point& place, double diameter = 0.004) {
  const Folder folder;
  folder.write("part.stl", stl(mesh));
  const auto frames = frames_of(folder, deck({.gravity = 0.0}) + ours("mesh part part.stl") +
                                            particles({{place[0], place[1], place[2], 0, 0, 0, diameter}}) + run(0, 1));
  return frames.back().at(1).force;
}

TEST(Wall, PushesFromAnEdgeAndFromAVertexOnceTowardsTheCentre) {
  for (const int n : {1, 4}) {
    const auto cube = box({-0.01, -0.01, -0.01}, {0, 0, 0}, n);
    const double radius = 0.002, overlap = 0.0001, off = radius - overlap;

    const double edge = off / std::sqrt(2.0), push = hertz(radius, overlap);
    const Point at_edge = force_at(cube, {edge, edge, -0.00361});
    EXPECT_NEAR(at_edge[0], push / std::sqrt(2.0), 1e-9 * push);
    EXPECT_NEAR(at_edge[1], push / std::sqrt(2.0), 1e-9 * push);
    EXPECT_NEAR(at_edge[2], 0.0, 1e-9 * push);

    const double vertex = off / std::sqrt(3.0);
    const Point at_vertex = force_at(cube, {vertex, vertex, vertex});
    for (double f : at_vertex) EXPECT_NEAR(f, push / std::sqrt(3.0), 1e-9 * push);

    const Point at_face = force_at(cube, {off, -0.0025, -0.0025});  // n = 4: where four cells meet
    EXPECT_NEAR(at_face[0], push, 1e-9 * push);
    EXPECT_NEAR(std::hypot(at_face[1], at_face[2]), 0.0, 1e-9 * push);
  }
}

// Deep enough to reach over seams and over the edge of the body: their triangles are not touched beside the face.
TEST(Wall, PushesOnceBesideSeamsAndEdges) {
  const double radius = 0.002, overlap = 1e-4, push = hertz(radius, overlap);
  for (const double beside : {0.1e-3, 0.3e-3, 0.5e-3}) {
    const auto fine = sheet({-0.012, -0.012, 0}, {0.024, 0, 0}, {0, 0.024, 0}, 24);
    const Point on_sheet = force_at(fine, {0.002 + beside, 0.001 + 0.5 * beside, radius - overlap});
    EXPECT_NEAR(on_sheet[2], push, 1e-9 * push) << beside;
    EXPECT_NEAR(std::hypot(on_sheet[0], on_sheet[1]), 0.0, 1e-9 * push) << beside;
    const Point by_edge = force_at(box({-0.01, -0.01, -0.01}, {0, 0, 0}, 2), {-beside, -0.0031, radius - overlap});
    EXPECT_NEAR(by_edge[2], push, 1e-9 * push) << beside;
    EXPECT_NEAR(std::hypot(by_edge[0], by_edge[1]), 0.0, 1e-9 * push) << beside;
  }
}

TEST(Wall, PushesFromBothFacesOfACorner) {
  auto corner = sheet({0, 0, 0}, {0.02, 0, 0}, {0, 0.02, 0}, 3);
  const auto wall = sheet({0, 0, 0}, {0, 0.02, 0}, {0, 0, 0.02}, 3);
  corner.insert(corner.end(), wall.begin(), wall.end());
  const double radius = 0.002;
  const Point force = force_at(corner, {radius - 1e-4, 0.01, radius - 2e-4});
  EXPECT_NEAR(force[0], hertz(radius, 1e-4), 1e-9 * force[0]);
  EXPECT_NEAR(force[2], hertz(radius, 2e-4), 1e-9 * force[2]);
  EXPECT_NEAR(force[1], 0.0, 1e-12);
}

TEST(Wall, PushesOnceFromAFinelyMeshedRoundWall) {
  std::vector<Corners> drum;
  const int n = 360;
  const double inner = 0.03;
  for (int k = 0; k < n; ++k) {
    const double a = 2 * kPi * k / n, b = 2 * kPi * (k + 1) / n;
    const auto strip =
        sheet({inner * std::cos(a), inner * std::sin(a), -0.02},
              {inner * (std::cos(b) - std::cos(a)), inner * (std::sin(b) - std::sin(a)), 0}, {0, 0, 0.04});
    drum.insert(drum.end(), strip.begin(), strip.end());
  }
  const double radius = 0.002, overlap = 1e-4, off = inner - radius + overlap;
  const double push = hertz(radius, overlap);
  for (const double angle : {0.0, 0.3 * kPi / n, kPi / n}) {
    const Point force = force_at(drum, {off * std::cos(angle), off * std::sin(angle), 0.001});
    EXPECT_NEAR(length(force), push, 0.03 * push) << angle;
  }
}

TEST(Wall, MeetsAThinBladeFromBothSidesAndOnlyOnce) {
  const double radius = 0.002, overlap = 3e-4, off = radius - overlap, push = hertz(radius, overlap);
  const auto leaf = sheet({-0.01, -0.01, 0}, {0.02, 0, 0}, {0, 0.02, 0}, 2);
  const double half = 5e-5;  // thinner than the overlap is deep
  const auto blade = box({-0.01, -0.01, -half}, {0.01, 0.01, half}, 2);
  for (const double side : {1.0, -1.0}) {
    EXPECT_NEAR(force_at(leaf, {0.003, 0.001, side * off})[2], side * push, 1e-9 * push);
    EXPECT_NEAR(force_at(blade, {0.003, 0.001, side * (off + half)})[2], side * push, 1e-9 * push);
    EXPECT_NEAR(force_at(blade, {0.0, 0.0, side * (off + half)})[2], side * push, 1e-9 * push);
  }
  // A wedge whose faces are 20 degrees apart: its far face is hidden by the near one.
  const double slope = std::tan(20.0 * kPi / 180.0);
  auto wedge = sheet({0, -0.01, 0}, {0.02, 0, 0}, {0, 0.02, 0});
  const auto below = sheet({0, -0.01, 0}, {0.02, 0, -0.02 * slope}, {0, 0.02, 0});
  wedge.insert(wedge.end(), below.begin(), below.end());
  const Point force = force_at(wedge, {0.001, 0.0, off});
  EXPECT_NEAR(force[2], push, 1e-9 * push);
  EXPECT_NEAR(force[0], 0.0, 1e-9 * push);
}

// ---- bodies that turn ----

std::vector<Corners> paddle() { return box({0.005, -0.001, -0.01}, {0.05, 0.001, 0.01}, 2); }

std::string before_the_paddle() {
  std::vector<TestParticle> list;
  for (int i = 0; i < 5; ++i) {
    const double r = 0.012 + 0.007 * i, angle = 0.25 + 0.11 * i;
    list.push_back({r * std::cos(angle), r * std::sin(angle), 0.002 * (i - 2), 0, 0, 0, i % 2 ? 0.003 : 0.004});
  }
  return particles(list);
}

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

// ---- ranks and restarts ----

/// A bed in a turning drum with a baffle: rolling, sliding, crossing from rank to rank.
std::string drum_deck(const Law& law, const std::string& state = "-0.06 0.06 -0.06 0.06 -0.03 0.06") {
  return deck(law, state);
}
std::string drum_walls(const Law& law) {
  return ours(
      "cylinder drum 0 0 0.01 0 1 0 0.03 plane left 0 -0.01 0 0 1 0 plane right 0 0.01 0 0 1 0 mesh baffle baffle.stl "
      "rotate drum 0 0 0.01 0 1 0 rad/s -60 rotate baffle 0 0 0.01 0 1 0 rad/s -60",
      law);
}
std::string bed() {
  std::vector<TestParticle> list;
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3; ++k)
        list.push_back({-0.0165 + 0.00411 * i + 1e-5 * k, -0.0071 + 0.00473 * j, -0.008 + 0.0047 * k, 0, 0, 0, 0.004});
  return particles(list);
}
const Law kDrumLaw{.models = "cohesion sjkr rolling_friction epsd2"};

void write_baffle(const Folder& folder) {
  folder.write("baffle.stl", stl(box({-0.029, -0.01, 0.009}, {-0.022, 0.01, 0.011}, 2)));
}

TEST(Wall, GivesTheSameOnTwoRanksAsOnOne) {
  const Folder folder;
  write_baffle(folder);
  Law law = kDrumLaw;
  const std::string end = bed() + print_vector(36) + run(3000, 300);
  const auto one = frames_of(folder, drum_deck(law) + drum_walls(law) + end);
  const auto values_of_one = read_vector(folder);
  law.more = "processors 2 1 1\n";
  const auto two = frames_of(folder, drum_deck(law) + drum_walls(law) + end, 2);
  const auto values_of_two = read_vector(folder);

  EXPECT_LT(difference(one, two), 1e-8);
  ASSERT_EQ(values_of_one.size(), values_of_two.size());
  const auto &a = values_of_one.rbegin()->second, &b = values_of_two.rbegin()->second;
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-4 * std::abs(a[k]) + 1e-7) << k;
  EXPECT_GT(a[7], 3.0);   // impacts on the baffle
  EXPECT_GT(a[34], 5.0);  // and on the drum
}

// Slow enough to roll, its springs loaded but not at their limits, when the first new neighbour list finds it beyond
// the border at x = 0: what it remembers must go with it.
TEST(Wall, CarriesTheHistoryOfATouchFromRankToRank) {
  const Folder folder;
  Law law{.models = "rolling_friction epsd2"};
  const std::string end =
      ours("plane floor 0 0 0 0 0 1", law) +
      particles({{-0.0004, 0.001, 0.001999, 0.05, 0, 0, 0.004}, {0.0004, 0.02, 0.001999, -0.05, 0, 0, 0.004}}) +
      run(10000, 20);
  const auto one = frames_of(folder, deck(law) + end);
  law.more = "processors 2 1 1\n";
  const auto two = frames_of(folder, deck(law) + end, 2);
  EXPECT_LT(difference(one, two), 1e-14);
  EXPECT_GT(one.back().at(1).x[0], 0.0001);
}

TEST(Wall, GoesOnOverARestartAsIfThereHadBeenNone) {
  const Folder folder;
  write_baffle(folder);
  // The restart makes a new neighbour list; so does the uncut run there.
  const auto whole =
      frames_of(folder, drum_deck(kDrumLaw) + drum_walls(kDrumLaw) + bed() + "run 2000\n" + run(1000, 100));
  ASSERT_EQ(run_deck(folder, drum_deck(kDrumLaw) + drum_walls(kDrumLaw) + bed() + "run 2000\nwrite_restart middle\n"),
            0)
      << folder.read("err");
  const auto after = frames_of(folder, drum_deck(kDrumLaw, "middle") + drum_walls(kDrumLaw) + run(1000, 100));

  EXPECT_LT(difference(whole, after), 1e-12);
  EXPECT_GT(whole.back().size(), 100u);
}

TEST(Wall, SaysWhatIsWrongWithItsArguments) {
  const Folder folder;
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"mesh part nowhere.stl", "nowhere.stl"},
      {"mesh part cut.stl", "cut.stl"},
      {"plane p 0 0 0 0 0 0", "direction"},
      {"cylinder c 0 0 0 0 0 1 -1", "radius"},
      {"plane p 0 0 0 0 0 1 rotate q 0 0 0 0 0 1 rpm 3", "no body of that name"},
      {"plane p 0 0 0 0 0 1 rotate p 0 0 0 0 0 1 hertz 3", "rpm"},
      {"plane p 0 0 0 0 0 1 plane p 0 0 1 0 0 1", "two bodies"},
      {"plane p 0 0 0 0 0 1 rolling_friction epsd", "cdt"},
      {"", "needs a body"}};
  folder.write("cut.stl", stl(floor_of(2)).substr(0, 300));
  for (const auto& [arguments, said] : wrong) {
    EXPECT_EQ(run_deck(folder, deck({}) + ours(arguments) + "run 1\n"), 2) << arguments;
    EXPECT_NE(folder.read("err").find(said), std::string::npos) << folder.read("err");
  }
}

TEST(Wall, RefusesATimeStepInWhichABladeCouldPassAParticle) {
  const Folder folder;
  folder.write("paddle.stl", stl(paddle()));
  // Tip at 50 mm, 5 us, smallest radius 1.5 mm: 3000 rad/s take it half a radius a step.
  const auto with_rate = [&](const std::string& rate) {
    return run_deck(folder, deck({}) + before_the_paddle() +
                                ours("mesh part paddle.stl rotate part 0 0 0 0 0 1 rad/s " + rate) + "run 0\n");
  };
  EXPECT_EQ(with_rate("2990"), 0) << folder.read("err");
  EXPECT_EQ(with_rate("-3010"), 2);
  EXPECT_NE(folder.read("err").find("body 'part'"), std::string::npos) << folder.read("err");
}

}  // namespace
}  // namespace granary::dem::test
