// Meshes, decks and read-back for the tests of granary/wall.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "tests/liggghts/plugin_deck.hpp"

namespace granary::dem::test {

using Point = std::array<double, 3>;
using Corners = std::array<Point, 3>;

constexpr double kPi = std::numbers::pi;
constexpr double kDensity = 1000.0, kRadius = 0.002, kMass = kDensity * 4.0 / 3.0 * kPi * kRadius * kRadius * kRadius;

inline double length(const Point& a) { return std::hypot(a[0], a[1], a[2]); }
inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// ---- meshes ----

inline std::string stl(const std::vector<Corners>& triangles) {
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
inline std::vector<Corners> sheet(const Point& corner, const Point& u, const Point& v, int n = 1) {
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
inline std::vector<Corners> box(const Point& low, const Point& high, int n = 1) {
  const Point x{high[0] - low[0], 0, 0}, y{0, high[1] - low[1], 0}, z{0, 0, high[2] - low[2]};
  std::vector<Corners> all;
  for (const auto& face :
       {sheet(low, y, x, n), sheet(low, x, z, n), sheet(low, z, y, n), sheet({low[0], low[1], high[2]}, x, y, n),
        sheet({low[0], high[1], low[2]}, z, x, n), sheet({high[0], low[1], low[2]}, y, z, n)})
    all.insert(all.end(), face.begin(), face.end());
  return all;
}

inline std::vector<Corners> floor_of(int n) { return sheet({-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}, n); }

// ---- decks ----

/// A run of one rank needs no daemon of Open MPI's, which takes longer to start than most of these runs take.
inline const int kWithoutDaemon = setenv("OMPI_MCA_ess_singleton_isolated", "1", 1);

constexpr double kYoung = 5e6, kWallYoung = 5e8, kPoisson = 0.3, kTimeStep = 5e-6;

struct Law {
  std::string models;  ///< after "tangential history"
  double restitution = 0.5, friction = 0.4;
  double gravity = 9.81;
  double wall_young = kWallYoung, time_step = kTimeStep;
  std::string more;  ///< commands before the box's contents, e.g. processors
  int types = 2;     ///< of the box; nothing has those above 2
};

/// Type 1: particles, type 2: walls. `state`: a box, or the name of a restart file.
inline std::string deck(const Law& law, const std::string& state = "-0.06 0.06 -0.06 0.06 -0.03 0.06") {
  std::ostringstream text;
  text << "atom_style granular\natom_modify map array\nboundary f f f\nnewton off\ncommunicate single vel yes\n"
       << "units si\n"
       << law.more
       << (state.find(' ') == std::string::npos
               ? "read_restart " + state + "\n"
               : "region box block " + state + " units box\ncreate_box " + std::to_string(law.types) + " box\n")
       << "neighbor 0.001 bin\nneigh_modify delay 0\n"
       << "fix m1 all property/global youngsModulus peratomtype " << kYoung;
  for (int t = 1; t < law.types; ++t) text << " " << law.wall_young;
  text << "\nfix m2 all property/global poissonsRatio peratomtype";
  for (int t = 0; t < law.types; ++t) text << " " << kPoisson;
  text << "\n";
  const auto pairs = [&](const char* name, const char* property, double value) {
    text << "fix " << name << " all property/global " << property << " peratomtypepair " << law.types;
    for (int k = 0; k < law.types * law.types; ++k) text << " " << value;
    text << "\n";
  };
  pairs("m3", "coefficientRestitution", law.restitution);
  pairs("m4", "coefficientFriction", law.friction);
  pairs("m5", "coefficientRollingFriction", 0.1);
  pairs("m6", "cohesionEnergyDensity", 3e3);
  text << "pair_style gran model hertz tangential history " << law.models << "\npair_coeff * *\n"
       << "timestep " << law.time_step << "\nfix integrate all nve/sphere\n"
       << "fix g all gravity " << law.gravity << " vector 0 0 -1\n"
       << "thermo 100000\nthermo_modify lost ignore norm no\n";
  return text.str();
}

inline std::string ours(const std::string& bodies, const Law& law = {}) {
  return "fix walls all granary/wall type 2 " + bodies + " " + law.models + "\n";
}
inline std::string stock_plane(const Law& law) {
  return "fix walls all wall/gran model hertz tangential history " + law.models + " primitive type 2 zplane 0.0\n";
}
inline std::string stock_mesh(const std::string& file, const Law& law) {
  return "fix part all mesh/surface file " + file + " type 2\nfix walls all wall/gran model hertz tangential history " +
         law.models + " mesh n_meshes 1 meshes part\n";
}

/// Runs and keeps x v omega f torque of all particles every so many steps.
inline std::string run(int steps, int every) {
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

inline std::vector<Frame> read_dump(const Folder& folder) {
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

inline std::vector<Frame> frames_of(const Folder& folder, const std::string& text, int ranks = 1) {
  EXPECT_EQ(run_deck(folder, text, ranks), 0) << folder.read("err");
  return read_dump(folder);
}

/// Largest difference of places [m], velocities [m/s] and spins over 1000/s, over all frames.
inline double difference(const std::vector<Frame>& a, const std::vector<Frame>& b) {
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
inline std::string print_vector(int n) {
  std::string variables, text;
  for (int k = 1; k <= n; ++k) {
    variables += "variable s" + std::to_string(k) + " equal f_walls[" + std::to_string(k) + "]\n";
    text += " ${s" + std::to_string(k) + "}";
  }
  return variables + "variable now equal step\nfix print all print 1 \"${now}" + text +
         "\" file values.txt screen no\n";
}
inline std::map<long, std::vector<double>> read_vector(const Folder& folder) {
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

inline double effective_young() {
  return 1.0 / ((1 - kPoisson * kPoisson) / kYoung + (1 - kPoisson * kPoisson) / kWallYoung);
}
inline double hertz(double radius, double overlap) {
  return 4.0 / 3.0 * effective_young() * std::sqrt(radius * overlap) * overlap;
}

inline std::vector<Corners> paddle() { return box({0.005, -0.001, -0.01}, {0.05, 0.001, 0.01}, 2); }

inline std::string before_the_paddle() {
  std::vector<TestParticle> list;
  for (int i = 0; i < 5; ++i) {
    const double r = 0.012 + 0.007 * i, angle = 0.25 + 0.11 * i;
    list.push_back({r * std::cos(angle), r * std::sin(angle), 0.002 * (i - 2), 0, 0, 0, i % 2 ? 0.003 : 0.004});
  }
  return particles(list);
}

// A normal and two oblique impacts, one with a bounce on it, and a slow slide: sticking, slipping, rolling.
inline std::string falling() {
  return particles({{-0.02, 0.013, 0.0025, 0, 0, -1, 0.004},
                    {-0.02, -0.013, 0.0025, 0.5, 0.3, -1, 0.004},
                    {0.01, -0.01, 0.0025, -0.5, 0.8, -2, 0.003},
                    {0.02, -0.021, 0.0019, -0.3, 0, 0, 0.004}});
}

}  // namespace granary::dem::test
