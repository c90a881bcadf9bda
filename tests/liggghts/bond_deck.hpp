// Decks and read-back for the tests of granary/bond.
#pragma once

#include "tests/liggghts/wall_deck.hpp"

namespace granary::dem::test {

constexpr double kSpacing = 0.0041;                                  // of spheres of 4 mm that do not touch
constexpr double kNormal = 1e9, kShear = 4e8, kBondRadius = 0.0016;  // [N/m^3], [N/m^3], [m]
constexpr double kArea = kPi * kBondRadius * kBondRadius;
constexpr double kSecondMoment = 0.25 * kArea * kBondRadius * kBondRadius;
constexpr double kInertia = 0.4 * kMass * kRadius * kRadius;
constexpr double kUnbreakable = 1e30;

struct Bonds {
  double normal = kNormal, shear = kShear, tensile_strength = kUnbreakable, shear_strength = kUnbreakable;
  double damping = 0.0;
  std::string more = "among group gap 3e-4";

  std::string fix() const {
    std::ostringstream text;
    text.precision(17);
    text << "fix bonds all granary/bond normal_stiffness " << normal << " shear_stiffness " << shear
         << " tensile_strength " << tensile_strength << " shear_strength " << shear_strength << " radius_scale "
         << kBondRadius / kRadius << " damping " << damping << " " << more << "\n";
    return text.str();
  }
};

struct BondBox {
  double time_step = 5e-6, young = 5e6, restitution = 0.5, friction = 0.3, skin = 0.001;
  std::string state = "-0.06 0.06 -0.06 0.06 -0.03 0.06";  ///< a box, or the name of a restart file
  std::string boundary = "f f f", more;
};
const BondBox kSlowBox{.time_step = 2e-5};  // for bonds in slow motion

/// Type 1: particles, type 2: walls. Nothing moves yet.
inline std::string bond_head(const BondBox& b) {
  std::ostringstream text;
  text << "atom_style granular\natom_modify map array\nboundary " << b.boundary
       << "\nnewton off\ncommunicate single vel yes\nunits si\n"
       << b.more
       << (b.state.find(' ') == std::string::npos ? "read_restart " + b.state + "\n"
                                                  : "region box block " + b.state + " units box\ncreate_box 2 box\n")
       << "neighbor " << b.skin << " bin\nneigh_modify delay 0\n"
       << "fix m1 all property/global youngsModulus peratomtype " << b.young << " " << 10 * b.young << "\n"
       << "fix m2 all property/global poissonsRatio peratomtype 0.3 0.3\n"
       << "fix m3 all property/global coefficientRestitution peratomtypepair 2";
  for (int k = 0; k < 4; ++k) text << " " << b.restitution;
  text << "\nfix m4 all property/global coefficientFriction peratomtypepair 2";
  for (int k = 0; k < 4; ++k) text << " " << b.friction;
  text << "\npair_style gran model hertz tangential history\npair_coeff * *\ntimestep " << b.time_step
       << "\nthermo 100000\nthermo_modify lost error norm no\n";
  return text.str();
}

inline const std::string kIntegrate = "fix integrate all nve/sphere\n";

/// n + 1 spheres along x, the first at 0. Group 'clamped' is the first, 'tip' the last, 'moving' all but the first.
inline std::string chain(int n) {
  std::vector<TestParticle> list;
  for (int i = 0; i <= n; ++i) list.push_back({i * kSpacing, 0, 0, 0, 0, 0, 2 * kRadius});
  return particles(list) + "group clamped id 1\ngroup tip id " + std::to_string(n + 1) +
         "\ngroup moving subtract all clamped\ngroup inner subtract moving tip\n";
}

/// side^3 spheres in a cubic lattice about the origin, each with a small velocity of its own.
inline std::string cube(int side, double speed) {
  std::vector<TestParticle> list;
  std::uint64_t state = 12345;
  const auto random = [&state] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 33) / 4294967296.0 * 4.0 - 1.0;
  };
  const double middle = 0.5 * (side - 1);
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j)
      for (int k = 0; k < side; ++k)
        list.push_back({(i - middle) * kSpacing, (j - middle) * kSpacing, (k - middle) * kSpacing, speed * random(),
                        speed * random(), speed * random(), 2 * kRadius});
  return particles(list);
}

/// fix_print of an equal-style expression list: printed.txt, a row each so many steps.
inline std::string print(const std::vector<std::string>& expressions, int every) {
  std::string variables, text;
  for (std::size_t k = 0; k < expressions.size(); ++k) {
    variables += "variable p" + std::to_string(k) + " equal " + expressions[k] + "\n";
    text += (k ? " $" : "$") + std::string("{p") + std::to_string(k) + "}";
  }
  return variables + "fix print all print " + std::to_string(every) + " \"" + text +
         "\" file printed.txt screen no title none\n";
}
inline std::vector<std::vector<double>> read_printed(const Folder& folder) {
  std::istringstream in(folder.read("printed.txt"));
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::vector<double> row;
    for (double value = 0.0; words >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

inline std::vector<json::Value> lines(const Folder& folder, const std::string& file) {
  auto read = json::read_lines(folder / file);
  EXPECT_TRUE(read.has_value()) << (read ? "" : read.error().message);
  return read ? *read : std::vector<json::Value>{};
}

}  // namespace granary::dem::test
