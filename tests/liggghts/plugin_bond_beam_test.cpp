// A chain of spheres bonded by granary/bond is a beam: bending, its frequency, torsion, with real LIGGGHTS.
#include "tests/liggghts/bond_deck.hpp"

namespace granary::dem::test {
namespace {

constexpr int kBonds = 12;
constexpr double kLength = kBonds * kSpacing;
constexpr double kBending = kNormal * kSecondMoment * kSpacing;  // E I [N m^2]: E = k_n L

// Each bond bends at its middle: the deflection of its end by every bond's angle and slip.
double deflection_of_chain(double force) {
  double angles = 0.0;
  for (int k = 0; k < kBonds; ++k) angles += std::pow((k + 0.5) * kSpacing, 2);
  return force * (angles / (kNormal * kSecondMoment) + kBonds / (kShear * kArea));
}

// First frequency of masses and moments of inertia on those springs, by iterating with the flexibility matrix.
double frequency_of_chain() {
  constexpr auto n = static_cast<std::size_t>(kBonds);
  std::vector<double> shape(2 * n, 1.0);  // deflections, rotations
  double value = 0.0;
  for (int round = 0; round < 60; ++round) {
    std::vector<double> next(2 * n, 0.0);
    for (std::size_t bond = 0; bond < n; ++bond) {
      const double place = (static_cast<double>(bond) + 0.5) * kSpacing;
      double moment = 0.0, shear = 0.0;
      for (std::size_t i = bond; i < n; ++i) {
        const double arm = static_cast<double>(i + 1) * kSpacing - place;
        moment += kMass * shape[i] * arm + kInertia * shape[n + i];
        shear += kMass * shape[i];
      }
      for (std::size_t i = bond; i < n; ++i) {
        const double arm = static_cast<double>(i + 1) * kSpacing - place;
        next[i] += moment / (kNormal * kSecondMoment) * arm + shear / (kShear * kArea);
        next[n + i] += moment / (kNormal * kSecondMoment);
      }
    }
    value = next[n - 1];
    for (double& x : next) x /= value;
    shape = next;
  }
  return 1.0 / std::sqrt(value);
}

TEST(Bond, ACantileverBendsAndSwingsAsBeamTheorySays) {
  const double force = 3e-5, frequency = frequency_of_chain();
  const Folder folder;
  std::ostringstream deck;
  deck << bond_head(kSlowBox) << Bonds{}.fix() << chain(kBonds) << "fix integrate moving nve/sphere\n"
       << "fix load tip addforce 0 0 " << force << "\nfix settle moving viscous " << 2.0 * kMass * frequency << "\n"
       << "run " << std::lround(16.0 / frequency / kSlowBox.time_step) << "\n"
       << print({"z[" + std::to_string(kBonds + 1) + "]"}, 1) << "run 1\nunfix load\nunfix settle\nrun "
       << std::lround(5.3 * 2.0 * kPi / frequency / kSlowBox.time_step) << "\n";
  ASSERT_EQ(run_deck(folder, deck.str()), 0) << folder.read("err");
  const auto rows = read_printed(folder);

  const double deflection = rows.front()[0];
  EXPECT_NEAR(deflection / deflection_of_chain(force), 1.0, 2e-4);
  EXPECT_NEAR(deflection / (force * std::pow(kLength, 3) / (3.0 * kBending)), 1.0, 2e-3);

  std::vector<double> crossings;
  for (std::size_t k = 1; k < rows.size(); ++k)
    if (rows[k - 1][0] > 0.0 && rows[k][0] <= 0.0)
      crossings.push_back(static_cast<double>(k) + rows[k][0] / (rows[k - 1][0] - rows[k][0]));
  ASSERT_GE(crossings.size(), 5u);
  const double period =
      (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1) * kSlowBox.time_step;
  const double measured = 2.0 * kPi / period;
  EXPECT_NEAR(measured / frequency, 1.0, 2e-3);
  // A beam of kBonds masses with half a mass more at its tip (S. Timoshenko, Vibration Problems in Engineering).
  const double beam = std::sqrt(3.0 * kBending / std::pow(kLength, 3) / (kMass * (0.2427 * kBonds + 0.5)));
  EXPECT_NEAR(measured / beam, 1.0, 1e-2);
}

TEST(Bond, AChainTwistsAsAShaft) {
  const double spin = 0.2;
  const int steps = 2500;
  const Folder folder;
  std::ostringstream deck;
  deck << bond_head(kSlowBox) << Bonds{.damping = 0.3}.fix() << chain(kBonds) << "fix integrate inner nve/sphere\n"
       << "set group tip omegax " << spin << "\n"
       << "run " << steps << "\nset group tip omegax 0\nrun 2000\n"
       << run(1, 1);
  const auto frames = frames_of(folder, deck.str());

  const double angle = spin * steps * kSlowBox.time_step;
  const double torque = 2.0 * kShear * kSecondMoment / kBonds * angle;  // G J / l with G = k_s L, J = 2 I
  const auto& end = frames.back();
  EXPECT_NEAR(end.at(1).torque[0] / torque, 1.0, 1e-4);
  EXPECT_NEAR(end.at(kBonds + 1).torque[0] / torque, -1.0, 1e-4);
  EXPECT_LT(length(end.at(1).force), 1e-9 * torque / kRadius);
}

}  // namespace
}  // namespace granary::dem::test
